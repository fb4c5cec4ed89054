"""How files are read: limits, checksums, what is refused."""

from tests.mutations import changes

MUTATIONS = [
    *changes(r"""
reading/regular.py | reading/test_regular.py -k pipes
a pipe is opened, and waited for
    if not stat.S_ISREG(found.st_mode): -> if stat.S_ISCHR(found.st_mode):

reading/regular.py | reading/test_regular.py -k empty
a file that grew is read whole
    if len(data) > limit: -> if len(data) > 2**40:

reading/documents.py | reading/test_documents.py -k brackets
brackets in text count as depth
    _STRING.sub("", _ESCAPE.sub("", text)) -> text

reading/arrays.py | reading/test_arrays.py -k header
an array is as large as its header says
    if file.tell() + prod(shape) * kind.itemsize != member.file_size: -> if prod(shape) < 0:

reading/arrays.py | reading/test_arrays.py -k unpacked
the size of the first array counts for all
    sum(member.file_size for member in members) -> members[0].file_size
an archive may be compressed by any method
    if member.compress_type not in _METHODS: -> if member.compress_type < 0:

reading/documents.py | reading/test_documents.py -k yaml
of a key that is given twice the last one counts
    if len(found) < len(node.value): -> if not found:

reading/pictures.py | reading/test_pictures.py -k fell_over
a picture's checksums are not compared
    if data[end : end + 4] != struct.pack(">I", zlib.crc32(view[start + 4 : end])):
        -> if end > len(data):

reading/checksums.py | reading/test_checksums.py
a checksum is over the names of what is said
    json.dumps(content, sort_keys=True -> json.dumps(sorted(content), sort_keys=True
what is sealed may be longer
    if sealed(payload) != data: -> if not data.startswith(sealed(payload)[:9]):

reading/pictures.py | reading/test_pictures.py
a PGM's values exceed its largest
    np.minimum(values, top).reshape -> np.asarray(values).reshape
the bytes of a deep PGM are swapped
    top < 256 else ">u2" -> top < 256 else "<u2"
comments within a plain PGM are pixels
    re.sub(rb"#[^\n]*", b"", body) -> body
"""),
    (
        "an anchor is read if nothing refers to it",
        "reading/documents.py",
        ' or getattr(event, "anchor", None)',
        "",
        "reading/test_documents.py -k yaml",
    ),
    (
        "a document's depth is counted on its way down only",
        "reading/documents.py",
        "        self.depth -= 1\n",
        "",
        "reading/test_documents.py -k yaml",
    ),
    (
        "a picture's size is not looked at before it is decoded",
        "reading/pictures.py",
        "    _check_size(width, height, MAX_PIXELS)\n",
        "",
        "reading/test_pictures.py -k too_large",
    ),
]
