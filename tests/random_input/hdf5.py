"""Changes of values, shapes, types and names in HDF5 files of isph, and checksums of its checkpoints.

Reads the parts of HDF5's format that isph writes at the root of a file, with contiguous data sets: in snapshots version 0
of the superblock and version 1 of object headers, in checkpoints version 2 of both, whose metadata have checksums. Bytes
change in place; Contents.seal() then corrects the checksums of the metadata.
"""
import math
import struct

from random_input.expressions import mutated

FLOATS = (0.0, -0.0, -1.0, 1e-310, 1e300, -1e300, math.nan, math.inf, -math.inf)
INTS = (0, 1, -1, 2, 7, 99, 2**31 - 1, 2**31, -2**31, 2**53 + 1, 2**63 - 1, -2**63)
SIZES = (0, 1, 2, 3, 5, 2**27, 2**31 - 1, 2**31, 2**32, 2**60, 2**63, 2**64 - 1)
INTEGER, FLOAT, STRING = 0, 1, 3  # classes of HDF5's types


class Item:
    """An attribute or a data set: places of its name, sizes, type and values in the bytes of the file."""

    def __init__(self, name, name_at, link_at=None):
        self.name, self.name_at, self.link_at = name, name_at, link_at
        self.sizes_at, self.shape, self.type_at, self.kind, self.width, self.at = 0, (), 0, -1, 0, None

    def count(self):
        return math.prod(self.shape)


def lookup3(data):
    """Returns the checksum of HDF5's metadata: hashlittle() of Jenkins' lookup3.c (2006), from 0."""

    def turned(x, k):
        return (x << k | x >> 32 - k) & 0xFFFFFFFF

    a = b = c = 0xDEADBEEF + len(data) & 0xFFFFFFFF
    length = -(-len(data) // 12) * 12
    words = struct.unpack(f"<{length // 4}I", data.ljust(length, b"\0"))
    for k in range(0, length // 4, 3):
        a, b, c = a + words[k] & 0xFFFFFFFF, b + words[k + 1] & 0xFFFFFFFF, c + words[k + 2] & 0xFFFFFFFF
        if k + 3 < len(words):
            for shift in 4, 6, 8, 16, 19, 4:
                a, b, c = b, c + b & 0xFFFFFFFF, (a - c & 0xFFFFFFFF) ^ turned(c, shift)
    for shift in 14, 11, 25, 16, 4, 14, 24:
        a, b, c = b, (c ^ b) - turned(b, shift) & 0xFFFFFFFF, a
    return b


class Contents:
    """The attributes and the data sets at the root of a file."""

    def __init__(self, data):
        self.data, self.attributes, self.sets, self.sealed = data, {}, {}, []
        assert data[8] in (0, 2), "superblock of another version"
        table = None
        for kind, at, _ in self.messages(self.number(0x24 if data[8] else 0x40)):
            if kind == 0x0C:
                item = self.attribute(at)
                self.attributes[item.name] = item
            elif kind == 0x06:
                self.link(at)
            elif kind == 0x11:
                table = self.number(at), self.number(self.number(at + 8) + 24)
        if table:
            self.links(*table)

    def seal(self):
        """Corrects the checksums of the metadata."""
        for begin, end in self.sealed:
            struct.pack_into("<I", self.data, end, lookup3(bytes(self.data[begin:end])))

    def number(self, at, size=8):
        return int.from_bytes(self.data[at:at + size], "little")

    def text(self, at):
        return self.data[at:self.data.index(0, at)].decode("latin-1")

    def messages(self, header):
        """Yields kind, place and length of each message of an object header."""
        if self.data[header:header + 4] == b"OHDR":
            yield from self.messages_2(header)
            return
        left = self.number(header + 2, 2)
        blocks = [(header + 16, self.number(header + 8, 4))]
        while blocks and left:
            at, length = blocks.pop(0)
            end = at + length
            while at + 8 <= end and left:
                kind, size = self.number(at, 2), self.number(at + 2, 2)
                if kind == 0x10:
                    blocks.append((self.number(at + 8), self.number(at + 16)))
                yield kind, at + 8, size
                at += 8 + size
                left -= 1

    def messages_2(self, header):
        """Yields the messages of an object header of version 2, and notes the parts that have checksums."""
        flags = self.data[header + 5]
        at, width = header + 6 + (16 if flags & 0x20 else 0) + (4 if flags & 0x10 else 0), 1 << (flags & 3)
        blocks = [(header, at + width, at + width + self.number(at, width))]
        head = 6 if flags & 4 else 4
        while blocks:
            begin, at, end = blocks.pop(0)
            assert (begin, end) not in self.sealed and end + 4 <= len(self.data), "a damaged header"
            self.sealed.append((begin, end))
            while at + head <= end:
                kind, size = self.data[at], self.number(at + 1, 2)
                if kind == 0x10:
                    place, length = self.number(at + head), self.number(at + head + 8)
                    blocks.append((place, place + 4, place + length - 4))
                yield kind, at + head, size
                at += head + size

    def shaped(self, item, at):
        rank = self.data[at + 1]
        item.sizes_at = at + (8 if self.data[at] == 1 else 4)
        item.shape = tuple(self.number(item.sizes_at + 8 * k) for k in range(rank))

    def typed(self, item, at):
        item.type_at, item.kind, item.width = at, self.data[at] & 15, self.number(at + 4, 4)

    def attribute(self, at):
        """Reads a message of version 1, whose parts begin at multiples of 8 bytes, or of version 3."""
        assert self.data[at] in (1, 3), "attribute of another version"
        first, unit = (at + 8, 8) if self.data[at] == 1 else (at + 9, 1)
        lengths = [-(-self.number(at + place, 2) // unit) * unit for place in (2, 4, 6)]
        item = Item(self.text(first), first)
        self.typed(item, first + lengths[0])
        self.shaped(item, first + lengths[0] + lengths[1])
        item.at = first + sum(lengths)
        return item

    def link(self, at):
        """Adds the data set to which a message leads, a hard link."""
        flags = self.data[at + 1]
        assert self.data[at] == 1 and not flags & 0x08, "a link of another kind"
        place, width = at + 2 + (8 if flags & 0x04 else 0) + (1 if flags & 0x10 else 0), 1 << (flags & 3)
        name_at, length = place + width, self.number(place, width)
        name = bytes(self.data[name_at:name_at + length]).decode("latin-1")
        self.data_set(Item(name, name_at, name_at + length))

    def data_set(self, item):
        for kind, place, _ in self.messages(self.number(item.link_at)):
            if kind == 1:
                self.shaped(item, place)
            elif kind == 3:
                self.typed(item, place)
            elif kind == 8 and self.data[place:place + 2] == b"\x03\x01":
                item.at = self.number(place + 2)
        if item.at is not None:
            self.sets[item.name] = item

    def links(self, node, heap):
        """Adds the data sets below a node of the tree of names."""
        for k in range(self.number(node + 6, 2)):
            child = self.number(node + 32 + 16 * k)
            if self.data[node:node + 4] == b"TREE" and self.data[child:child + 4] == b"TREE":
                self.links(child, heap)
                continue
            for entry in range(self.number(child + 6, 2)):
                at = child + 8 + 40 * entry
                name_at = heap + self.number(at)
                self.data_set(Item(self.text(name_at), name_at, at + 8))

    def holds(self, item):
        return item.at + item.count() * item.width <= len(self.data)

    def values(self, name):
        """Returns the values of an attribute or a data set; None: none that can be read."""
        item = self.attributes.get(name) or self.sets.get(name)
        if not item or not self.holds(item):
            return None
        raw = bytes(self.data[item.at:item.at + item.count() * item.width])
        if item.kind == STRING:
            return raw.split(b"\0")[0]
        code = {(INTEGER, 4): "i", (INTEGER, 8): "q", (FLOAT, 8): "d"}.get((item.kind, item.width))
        return code and struct.unpack(f"<{item.count()}{code}", raw)


# ---- the checksum of src/run/identity.c ----


def hashed(words):
    total = 14695981039346656037
    for word in words:
        total = (total ^ word) * 1099511628211 % 2**64
        total ^= total >> 29
    return total


def bits(numbers):
    return struct.unpack(f"<{len(numbers)}Q", struct.pack(f"<{len(numbers)}d", *numbers))


def checksum(contents):
    """Returns the checksum of a checkpoint; None: a part of it cannot be read."""
    words = [contents.values(name) for name in ("memory_names", "report_names")]
    numbers = [contents.values(name) for name in sorted(contents.sets) if name not in ("particles", "kept")]
    first, records, kept = contents.values("next_id"), contents.values("particles"), contents.values("kept")
    if not first or not records or None in words or None in numbers:
        return None
    width = contents.sets["particles"].shape[-1]
    rows = [records[k:k + width] for k in range(0, len(records), width)]
    pairs = [(float(k), value) for k, value in enumerate(kept or ())]
    tables = [(float(first[0]),), *numbers, *pairs, *rows]
    return sum(map(hashed, words + [bits(table) for table in tables])) % 2**64


# ---- changes ----


def change_value(rng, contents, item):
    """Changes one value or a few, mostly to an odd one; none of an item that an earlier change made too long."""
    data = contents.data
    if not contents.holds(item):
        return
    if item.kind == STRING:
        text = mutated(rng, contents.values(item.name).decode("latin-1")).encode(errors="replace")
        data[item.at:item.at + item.width] = text[:item.width].ljust(item.width, b"\0")
        return
    for _ in range(rng.choice((1, 1, 1, 2, 20))):
        at = item.at + item.width * rng.randrange(max(1, item.count()))
        if item.kind == FLOAT:
            old = struct.unpack_from("<d", data, at)[0]
            new = rng.choice(FLOATS + (-old, 2 * old, 1e9 * old, old + 1, old * (1 + 1e-9), rng.uniform(-2, 2)))
            struct.pack_into("<d", data, at, new)
        else:
            old = contents.number(at, item.width)
            new = rng.choice(INTS + (-old, old + 1, old - 1, 2 * old)) % 2**(8 * item.width)
            data[at:at + item.width] = new.to_bytes(item.width, "little")


def change_shape(rng, contents, item):
    """Changes a size, or exchanges two."""
    at = item.sizes_at + 8 * rng.randrange(max(1, len(item.shape)))
    old = contents.number(at)
    new = rng.choice(SIZES + (old + 1, abs(old - 1), 2 * old, old // 2)) % 2**64
    if len(item.shape) == 2 and rng.random() < 0.2:
        contents.data[item.sizes_at:item.sizes_at + 16] = struct.pack("<2Q", *reversed(item.shape))
    elif item.shape:
        contents.data[at:at + 8] = new.to_bytes(8, "little")


def change_type(rng, contents, item):
    """Changes the class of the values, or their width."""
    if rng.random() < 0.5:
        contents.data[item.type_at] = 16 + rng.randrange(11)
    else:
        width = rng.choice((0, 1, 2, 4, 8, 16, 2**31))
        contents.data[item.type_at + 4:item.type_at + 8] = width.to_bytes(4, "little")


def change_name(rng, contents, item):
    contents.data[item.name_at + rng.randrange(len(item.name))] = rng.choice(b"\0abcz/._\xff")


def change_link(rng, contents, item):
    """Exchanges the places of two data sets, which exchange their names thereby."""
    other = rng.choice(sorted(contents.sets))
    if item.link_at is not None:
        a, b, data = item.link_at, contents.sets[other].link_at, contents.data
        data[a:a + 8], data[b:b + 8] = data[b:b + 8], data[a:a + 8]


CHANGES = (change_value, change_shape, change_type, change_name, change_link)
SHARES = (70, 12, 6, 6, 6)  # of the changes


def changed(rng, original, names=None):
    """Returns a file with one change or two, mostly of names, and mostly with the right checksum if it has one."""
    data = bytearray(original)
    for _ in range(rng.choice((1, 1, 1, 2))):
        contents = Contents(data)
        some = rng.choice((contents.attributes, contents.sets))
        if names and rng.random() < 0.9:
            some = {name: contents.sets[name] for name in names if name in contents.sets} or some
        item = some[rng.choice(sorted(some))]
        rng.choices(CHANGES, SHARES)[0](rng, contents, item)
        contents.seal()
        try:
            contents = Contents(data)
        except (AssertionError, IndexError, ValueError):  # the change made it unreadable
            return bytes(data)
    if "checksum" in contents.attributes and rng.random() < 0.95:
        right = checksum(contents)
        if right is not None:
            struct.pack_into("<Q", data, contents.attributes["checksum"].at, right)
            contents.seal()
    return bytes(data)
