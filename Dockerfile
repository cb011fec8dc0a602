# updamp with all it needs. docker build -t updamp . && docker run --rm -v "$PWD:/work" updamp init first
FROM python:3.11-slim AS wheel
WORKDIR /source
COPY . .
RUN pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.11-slim
# What gmsh and pyvista load; the list is that of system-packages.txt.
COPY system-packages.txt requirements.lock /tmp/
RUN apt-get update \
    && apt-get install --yes --no-install-recommends $(awk '/^lib/ && !/suitesparse/ { print $1 }' /tmp/system-packages.txt) \
    && rm -rf /var/lib/apt/lists/*
COPY --from=wheel /wheels /wheels
RUN pip install --no-cache-dir --constraint /tmp/requirements.lock /wheels/*.whl
WORKDIR /work
ENTRYPOINT ["updamp"]
