"""Pliant: soft bodies. The C interface as classes; see the headers for what functions do.

A function pli_body_enable_tethers(body, def) is body.enable_tethers(...): the fields of the definition are named
arguments, and what is left out has its default. Other parameters are given in their order or by name, `from_` for C's
`from`. Vectors are sequences of numbers, arrays are NumPy arrays or what can
become one. A status other than PLI_OK is raised as an Error with the library's message. What C returns by pointers is
returned, as a tuple where there are several.
"""

import functools
import re
import weakref

import numpy as np

from . import _convert
from ._convert import Handle
from ._library import constants, declarations, ffi, functions, lib

globals().update(constants)


class Error(Exception):
    """What a call was refused for. `status`: its name, as "PLI_ERROR_INVALID_VALUE"."""

    def __init__(self, status, message):
        super().__init__(message)
        self.status = status


class Context(Handle):
    """Memory, messages and threads; the first thing that a program makes."""

    def __init__(self, threads=1, **fields):
        if threads > 1:
            self._threads = _Threads(threads)
            fields["parallel_for"] = ffi.addressof(lib, "pli_threads_parallel_for")
            fields["parallel_user"] = self._threads.pointer
        self._pointer = _call("pli_context_create", [], fields, None)
        weakref.finalize(self, lib.pli_context_destroy, self._pointer)


class _Threads(Handle):
    """A pool, which ends after its context."""

    def __init__(self, count):
        made = ffi.new("pli_threads**")
        if lib.pli_threads_create(count, made) != lib.PLI_OK:
            raise Error("PLI_ERROR_INVALID_VALUE", f"no pool of {count} threads")
        self._pointer = made[0]
        weakref.finalize(self, lib.pli_threads_destroy, self._pointer)


class _Part(Handle):
    """Lives in a context; ends with the last reference, not before what needs it."""

    def __init__(self, context, pointer, release):
        self._context = context
        self._pointer = pointer
        weakref.finalize(self, release, pointer)


class Mesh(_Part):
    """Nodes, links, faces and masses, from which bodies are made."""

    def __init__(self, context, pointer=None):
        pointer = _call("pli_mesh_create", [context], {}, context) if pointer is None else pointer
        super().__init__(context, pointer, lib.pli_mesh_destroy)

    @property
    def positions(self):
        """[nodes, 3] m, a copy"""
        view = lib.pli_mesh_get_view(self.pointer)
        memory = ffi.buffer(view.positions, 12 * view.node_count) if view.node_count > 0 else b""
        return np.frombuffer(memory, np.float32).reshape(-1, 3).copy()


class Shape(_Part):
    """What rigid bodies are made of."""

    def __init__(self, context, pointer):
        super().__init__(context, pointer, lib.pli_shape_release)


class World(_Part):
    """Bodies and rigid bodies that are stepped together."""

    def __init__(self, context, pointer=None, **fields):
        pointer = _call("pli_world_create", [context], fields, context) if pointer is None else pointer
        self._handles = weakref.WeakValueDictionary()
        super().__init__(context, pointer, lib.pli_world_destroy)

    def step(self, dt):
        """pli_world_step; takes the shortest way, since it is called most."""
        status = lib.pli_world_step(self._pointer, dt)
        if status != lib.PLI_OK:
            _raise(status, self._context)

    def save(self):
        """pli_world_save, as bytes."""
        size = lib.pli_world_snapshot_size(self.pointer)
        memory = ffi.new("char[]", size)
        _call("pli_world_save", [self, memory, size, None], {}, self._context)
        return ffi.buffer(memory)[:]

    def restore(self, snapshot):
        """pli_world_restore."""
        _call("pli_world_restore", [self, ffi.from_buffer(snapshot), len(snapshot)], {}, self._context)

    def _handle(self, kind, pointer):
        address = int(ffi.cast("uintptr_t", pointer))
        known = self._handles.get(address)
        if known is None:
            known = self._handles[address] = kind(self, pointer)
        return known

    @property
    def bodies(self):
        count = lib.pli_world_body_count(self.pointer)
        return [self._handle(Body, lib.pli_world_get_body(self.pointer, i)) for i in range(count)]


class _Member(Handle):
    """Belongs to its world, and stays in it when Python forgets it."""

    def __init__(self, world, pointer):
        self._world = world
        self._context = world._context
        self._pointer = pointer

    @property
    def world(self):
        return self._world

    def _forget(self):
        del self._world._handles[int(ffi.cast("uintptr_t", self._pointer))]
        self._pointer = None


class Rigid(_Member):
    """A rigid body as soft bodies see it; its host moves it."""

    def destroy(self):
        """pli_rigid_destroy."""
        lib.pli_rigid_destroy(self.pointer)
        self._forget()


class _View:
    """Memory of a body, for NumPy, which keeps it and so the body."""

    def __init__(self, body, pointer, shape, strides, kind):
        self.body = body
        address = int(ffi.cast("uintptr_t", pointer))
        self.__array_interface__ = {
            "version": 3, "shape": shape, "strides": strides, "typestr": kind, "data": (address, True)}


class Body(_Member):
    """A soft body. Arrays of it show its memory, read-only, and change with each step."""

    def __init__(self, world, pointer):
        super().__init__(world, pointer)
        self._views = weakref.WeakSet()

    def _array(self, pointer, count, columns, stride=None, kind="<f4"):
        if pointer == ffi.NULL or count == 0:
            return np.empty((0, columns), dtype=kind)
        view = _View(self, pointer, (count, columns), (4 * (stride or columns), 4), kind)
        self._views.add(view)
        return np.asarray(view)

    def _check_no_views(self, what):
        if len(self._views) > 0:
            raise BufferError(f"{what} moves or frees what {len(self._views)} arrays of the body show")

    @property
    def positions(self):
        """[nodes, 3] m"""
        view = lib.pli_body_get_view(self.pointer)
        return self._array(view.positions, view.node_count, 3, 4)

    @property
    def velocities(self):
        """[nodes, 3] m/s"""
        view = lib.pli_body_get_view(self.pointer)
        return self._array(view.velocities, view.node_count, 3, 4)

    @property
    def inverse_masses(self):
        """[nodes] 1/kg, 0 where a node is pinned"""
        view = lib.pli_body_get_view(self.pointer)
        return self._array(ffi.cast("float*", view.positions) + 3, view.node_count, 1, 4)[:, 0]

    @property
    def normals(self):
        """[nodes, 3] of unit length, a copy, since features free them; empty when none needs them"""
        view = lib.pli_body_get_view(self.pointer)
        return self._array(view.normals, view.node_count, 3).copy()

    @property
    def links(self):
        """[links, 2] nodes"""
        view = lib.pli_body_get_view(self.pointer)
        return self._array(view.link_nodes, view.link_count, 2, view.link_node_stride, "<i4")

    @property
    def faces(self):
        """[faces, 3] nodes"""
        view = lib.pli_body_get_view(self.pointer)
        return self._array(view.face_nodes, view.face_count, 3, kind="<i4")

    @property
    def tetras(self):
        """[tetrahedra, 4] nodes"""
        view = lib.pli_body_get_view(self.pointer)
        return self._array(view.tetra_nodes, view.tetra_count, 4, kind="<i4")

    def set_state(self, positions, velocities=None):
        """pli_body_set_state, [nodes, 3] each."""
        count = lib.pli_body_get_view(self.pointer).node_count
        for array in (positions, velocities):
            if array is not None and np.shape(array) != (count, 3):
                raise ValueError(f"the body has {count} nodes, the array has the shape {np.shape(array)}")
        _call("pli_body_set_state", [self, positions, velocities], {}, self._context)

    def destroy(self):
        """pli_body_destroy. Not while arrays of it are in use."""
        self._check_no_views("destroy")
        lib.pli_body_destroy(self.pointer)
        self._forget()


_KINDS = {"pli_context": Context, "pli_world": World, "pli_mesh": Mesh, "pli_body": Body, "pli_shape": Shape,
          "pli_rigid": Rigid}


def _raise(status, context):
    text = ffi.string(lib.pli_last_error(context.pointer if context is not None else ffi.NULL)).decode()
    name = ffi.typeof("pli_status").elements.get(status, "error")
    raise Error(name, text or name)


def _is_output(kind):
    return (kind.kind == "pointer" and not kind.cname.startswith("const") and kind.item.cname not in _KINDS
            and kind.item.cname not in ("void", "char") and kind.item.kind != "function")


def _wrap_pointer(kind, pointer, context, world):
    wrapped = _KINDS[kind.item.cname]
    if wrapped in (Body, Rigid):
        return world._handle(wrapped, pointer)
    return wrapped(context, pointer)


def _is_const(signature, index):
    return signature[index].lstrip().startswith("const ")


@functools.cache
def _signature(name):
    """The parameters as they are declared: cffi's types do not tell what is constant, nor names."""
    match = re.search(rf"\b{name}\(([^;]*?)\);", declarations, re.S)
    return [" ".join(part.split()) for part in match[1].split(",")] if match else []


def _read_list(name, owner, context):
    """Of a function that writes at most `capacity` items and returns how many there are."""
    kind = ffi.typeof(getattr(lib, name))
    count = getattr(lib, name)(owner.pointer, 0, ffi.NULL)
    items = ffi.new(ffi.typeof(f"{kind.args[2].item.cname}[]"), max(count, 1))
    count = min(count, getattr(lib, name)(owner.pointer, count, items))
    world = owner if isinstance(owner, World) else getattr(owner, "_world", None)
    return [_item(_convert.result_of(items[i]), world) for i in range(count)]


def _item(value, world):
    """Of a list: bodies and rigid bodies in it are those that Python knows."""
    if isinstance(value, dict):
        return {name: _item(each, world) for name, each in value.items()}
    if not isinstance(value, ffi.CData):
        return value
    kind = ffi.typeof(value)
    if kind.kind != "pointer" or kind.item.cname not in ("pli_body", "pli_rigid"):
        return value
    return world._handle(_KINDS[kind.item.cname], value) if value != ffi.NULL else None


# Arrays that C writes into memory of the caller, and what counts them.
_LENGTHS_OF_OUTPUTS = {("pli_mesh_create_from_vertices", "vertex_nodes"): "vertex_count"}


def _call(name, arguments, fields, context):
    """Calls with the arguments in their order, then by name; definitions are made of the other `fields`, outputs are
    returned."""
    function = getattr(lib, name)
    kind = ffi.typeof(function)
    declared = _signature(name)
    words = [part.split()[-1] for part in declared]
    values, outputs, kept, given = [], [], [], {}
    arguments = list(arguments)
    fields = {"from" if each == "from_" else each: value for each, value in fields.items()}
    named = {word: fields.pop(word) for word in words[len(arguments):] if word in fields}
    for index, parameter in enumerate(kind.args):
        is_definition = parameter.kind == "pointer" and parameter.item.cname.endswith("_def")
        if is_definition and not (arguments and isinstance(arguments[0], (dict, ffi.CData))):
            definition = _convert.default_of(parameter.item)
            _convert.fill(definition[0], fields, kept)
            fields = {}
            values.append(definition)
        elif not arguments and words[index] in named:
            given[words[index]] = named[words[index]]
            values.append(_convert.value_of(parameter, named.pop(words[index]), kept))
        elif not arguments and _is_output(parameter) and not _is_const(declared, index):
            length = _LENGTHS_OF_OUTPUTS.get((name, words[index]))
            if length is None:
                memory = ffi.new(ffi.typeof(f"{parameter.item.cname}*"))
            else:
                memory = np.zeros(given[length], _convert.array_type(parameter.item)[0])
            outputs.append((parameter, memory))
            values.append(_convert.value_of(parameter, memory, kept))
        elif arguments:
            given[words[index]] = arguments[0]
            values.append(_convert.value_of(parameter, arguments.pop(0), kept))
        else:
            raise TypeError(f"{name} wants {', '.join(declared)}")
    if arguments or fields or named:
        raise TypeError(f"{name} wants {', '.join(declared)}; left over: {arguments or fields or named}")
    for array, value in given.items():
        count = _convert.count_of(array, given)
        if count is not None and count != array and isinstance(value, (list, tuple, np.ndarray)):
            _convert.check_length(array, value, count, given[count])
    result = function(*values)
    returns_status = kind.result.cname == "pli_status"
    if returns_status and result != lib.PLI_OK:
        _raise(result, context)
    world = next((each if isinstance(each, World) else each._world for each in kept
                  if isinstance(each, (World, _Member))), None)
    results = [] if returns_status or kind.result.cname == "void" else [result]
    if kind.result.kind == "pointer" and kind.result.item.kind == "struct" and len(outputs) == 1 \
            and kind.result.item.cname not in _KINDS:
        return [_item(_convert.result_of(result[i]), world) for i in range(outputs[0][1][0])]
    for parameter, memory in outputs:
        results.append(memory if isinstance(memory, np.ndarray) else memory[0])
    if name == "pli_context_create":
        return results[0]
    results = [_finish(each, context, world, name) for each in results]
    return results[0] if len(results) == 1 else tuple(results) if results else None


def _finish(value, context, world, name):
    if isinstance(value, ffi.CData):
        kind = ffi.typeof(value)
        if kind.kind == "pointer" and kind.item.cname in _KINDS:
            if value == ffi.NULL:
                return None
            if name in ("pli_mesh_create", "pli_world_create"):
                return value
            return _wrap_pointer(kind, value, context, world)
        if kind.kind == "struct" and kind.cname.endswith("_id"):
            return value
    return _convert.result_of(value)


def _shown(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{name}": {_shown(each)}' for name, each in value.items()) + "}"
    if isinstance(value, tuple):
        return "(" + ", ".join(map(_shown, value)) + ")"
    return f"{value:g}" if isinstance(value, float) else "None" if isinstance(value, ffi.CData) else repr(value)


def _defaults_of(name):
    """For `help`: what a call takes by name, with the defaults."""
    for kind in ffi.typeof(getattr(lib, name)).args:
        if kind.kind == "pointer" and kind.item.cname.endswith("_def"):
            fields = _convert.result_of(_convert.default_of(kind.item)[0])
            return "\n\n" + ", ".join(f"{field}={_shown(value)}" for field, value in fields.items())
    return ""


def _method(name, owner):
    declared = _signature(name)
    takes_owner = bool(declared) and owner in declared[0].split("*")[0].split() and "**" not in declared[0]
    changes_arrays = owner == "pli_body" and any(word in name for word in ("_cut", "refine"))
    is_list = len(declared) == 3 and declared[1] == "int capacity"

    def method(self, *arguments, **fields):
        if changes_arrays:
            self._check_no_views(name)
        if name == "pli_world_file_restore":
            for body in self.bodies:
                body._check_no_views(name)
        context = self if isinstance(self, Context) else self._context
        if is_list:
            return _read_list(name, self, context)
        return _call(name, [self, *arguments], fields, context)

    def factory(parent, *arguments, **fields):
        context = parent if isinstance(parent, Context) else parent._context
        return _call(name, [parent, *arguments], fields, context)

    made = method if takes_owner else staticmethod(factory)
    target = made if takes_owner else factory
    target.__name__ = name[len(owner) + 1:]
    target.__doc__ = f"{name}({', '.join(declared)})" + _defaults_of(name)
    return made


def _add_methods():
    # Made and ended by the classes, hooks that Python is too slow for, and arrays of lengths that only C knows.
    left_out = {"destroy", "release", "retain", "create", "save", "restore", "snapshot_size", "set_profile",
                "create_patch_uv", "get_view"}
    for owner, kind in _KINDS.items():
        for name in functions:
            if not name.startswith(owner + "_"):
                continue
            short = name[len(owner) + 1:]
            is_factory = short == "create" and kind in (Body, Rigid)
            if (short in left_out and not is_factory) or short in vars(kind) or short.endswith("_default"):
                continue
            setattr(kind, short, _method(name, owner))


_add_methods()
