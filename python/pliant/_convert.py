"""Between Python's values and those of C, by the types that the headers declare."""

import numpy as np

from ._library import ffi, lib

VECTORS = {"pli_vec3": 3, "pli_vec4": 4, "pli_quat": 4}
NUMBERS = {"float": np.float32, "int": np.int32, "double": np.float64, "uint8_t": np.uint8, "uint64_t": np.uint64}


class Handle:
    """An object of the library. Keeps alive what it lives in."""

    _pointer = None

    def __bool__(self):
        return self._pointer is not None

    @property
    def pointer(self):
        if self._pointer is None:
            raise ReferenceError(f"this {type(self).__name__} has been destroyed")
        return self._pointer


def array_type(item):
    """The type of a NumPy array of such items, and how many numbers an item has; None where there is no such array."""
    if item.cname in VECTORS:
        return np.float32, VECTORS[item.cname]
    return (NUMBERS[item.cname], 1) if item.cname in NUMBERS else None


def array_pointer(kind, value, kept):
    """A pointer to the values of something like an array."""
    item = kind.item
    layout = array_type(item)
    if item.cname == "void":
        memory = ffi.from_buffer(value)
    elif layout is None:
        values = [value_of(item, each, kept) for each in value]
        memory = ffi.new(ffi.typeof(f"{item.cname}[]"), values)
    else:
        array = np.ascontiguousarray(value, dtype=layout[0])
        if layout[1] > 1 and (array.ndim < 1 or array.shape[-1] != layout[1]):
            raise ValueError(f"an array of {item.cname} has {layout[1]} columns, this one has the shape {array.shape}")
        kept.append(array)
        memory = ffi.cast(kind, ffi.from_buffer(array))
    kept.append(memory)
    return memory


NUMBERS_OF = {"triangles": 3, "tetras": 4}  # of those that are lists of nodes


def count_of(name, names):
    """What counts the array of that name, or None."""
    stem = name.replace("vertices", "vertexs").rstrip("s")
    return next((count for count in (f"{stem}_count", f"{stem.split('_')[0]}_count", "count") if count in names), None)


def check_length(name, array, count_name, count):
    """C reads as many items as it is told."""
    needed = count * NUMBERS_OF.get(name, 1)
    present = np.size(array) if name in NUMBERS_OF else len(array)
    if present < needed:
        raise ValueError(f"{name} has {present} items, {count_name} = {count} wants {needed}")


def fill(structure, fields, kept):
    """Sets fields by name. Arrays bring their length with them, where a field counts them."""
    kinds = dict(ffi.typeof(structure).fields)
    lengths = {}
    for name, value in fields.items():
        if name not in kinds or name == "cookie":
            raise TypeError(f"{ffi.typeof(structure).cname} has no field {name!r}; it has {', '.join(kinds)}")
        kind = kinds[name].type
        if kind.kind == "struct" and isinstance(value, dict):
            fill(getattr(structure, name), value, kept)
            continue
        setattr(structure, name, value_of(kind, value, kept))
        count = count_of(name, kinds)
        if count is None or kind.kind != "pointer" or not hasattr(value, "__len__") or isinstance(value, (str, bytes)):
            continue
        if count in fields:
            check_length(name, value, count, fields[count])
        elif lengths.setdefault(count, len(value)) != len(value):
            raise ValueError(f"{name} has {len(value)} items, another array {lengths[count]}")
        else:
            setattr(structure, count, len(value))


def value_of(kind, value, kept):
    """The C value of that type. `kept`: what has to live until the call is over."""
    if isinstance(value, ffi.CData):
        return value
    if kind.kind == "array":
        return np.asarray(value).tolist()
    if kind.kind == "pointer":
        if value is None:
            return ffi.NULL
        if isinstance(value, Handle):
            kept.append(value)
            return value.pointer
        if isinstance(value, (str, bytes)):
            text = ffi.new("char[]", value.encode() if isinstance(value, str) else value)
            kept.append(text)
            return text
        if isinstance(value, dict):
            structure = default_of(kind.item)
            fill(structure[0], value, kept)
            kept.append(structure)
            return structure
        return array_pointer(kind, value, kept)
    if kind.kind == "struct":
        if isinstance(value, dict):
            structure = default_of(kind)
            fill(structure[0], value, kept)
            kept.append(structure)
            return structure[0]
        return ffi.new(ffi.typeof(f"{kind.cname}*"), to_nested(kind, value))[0]
    if kind.kind == "enum" and isinstance(value, str):
        names = [name for name in kind.relements if name.lower().endswith("_" + value.lower())]
        if len(names) != 1:
            raise ValueError(f"{value!r} is none of {', '.join(kind.relements)}")
        return kind.relements[names[0]]
    return value


def to_nested(kind, value):
    """Numbers in the nesting of the structure: a matrix is rows of vectors."""
    if kind.cname == "pli_mat3":
        return [np.asarray(value, dtype=float).reshape(3, 3).tolist()]
    if kind.kind == "struct":
        if not hasattr(value, "__len__") or len(value) != len(kind.fields):
            raise ValueError(f"{kind.cname} has {', '.join(name for name, _ in kind.fields)}, given was {value!r}")
        return [to_nested(field.type, each) for (_, field), each in zip(kind.fields, value)]
    if kind.kind == "array":
        return [to_nested(kind.item, each) for each in value]
    return float(value)


def result_of(value):
    """A Python value of what C returned: tuples for vectors, dictionaries for other structures."""
    if not isinstance(value, ffi.CData):
        return value
    kind = ffi.typeof(value)
    if kind.kind == "struct":
        if kind.cname in VECTORS:
            return tuple(getattr(value, name) for name, _ in kind.fields)
        return {name: result_of(getattr(value, name)) for name, _ in kind.fields if name != "cookie"}
    if kind.kind == "pointer" and kind.item.cname == "char":
        return ffi.string(value).decode() if value != ffi.NULL else None
    if kind.kind == "array":
        return [result_of(each) for each in value]
    return value


def default_of(kind):
    """What pli_..._default gives, or zeros."""
    make = getattr(lib, f"{kind.cname}_default", None)
    structure = ffi.new(ffi.typeof(f"{kind.cname}*"))
    if make is not None:
        structure[0] = make()
    return structure
