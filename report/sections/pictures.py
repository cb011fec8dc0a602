"""Pictures made elsewhere, put into the page."""

from base64 import b64encode
from html import escape

from updamp.report.section import Content, Report, ReportSection

PNG = b"\x89PNG\r\n\x1a\n"


def render(report: Report) -> Content | None:
    """raises: ValueError for a picture that is no PNG"""
    for caption, content in report.pictures.items():
        if not content.startswith(PNG):
            raise ValueError(f"picture '{caption}' is no PNG (starts with {content[:8]!r}): save it as one")
    html = "".join(
        f'<figure class="picture"><img alt="{escape(caption)}" src="data:image/png;base64,'
        f'{b64encode(content).decode()}"><figcaption>{escape(caption)}</figcaption></figure>'
        for caption, content in report.pictures.items()
    )
    return Content(f'<div class="pictures">{html}</div>') if html else None


SECTION = ReportSection("pictures", "Pictures", render)
