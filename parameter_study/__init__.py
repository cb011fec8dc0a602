"""Parameter studies: response curves of many variants of one rig, their pictures, and findings that can fail."""
