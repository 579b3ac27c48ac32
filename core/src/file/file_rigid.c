/* Rigid bodies in files, with their shapes. */

#include "file/file_impl.h"

#include "shape/shape_impl.h"

enum { FILE_SHAPE_NUMBERS = 8 }; /* of the kinds that a file has whole */

/* What it is made from. */
static const plii_state_part file_rigid_first_parts[] = {
    PLII_STATE_OF(pli_rigid, kind, PLII_SAVED, "e2"),
    PLII_STATE_OF(pli_rigid, state, PLII_SAVED, "28f"),
    PLII_STATE_SPAN(pli_rigid, friction, angular_factor, PLII_SAVED, "8f"),
    {0},
};

static const plii_state_part file_rigid_parts[] = {
    PLII_STATE_SPAN(pli_rigid, is_absent, is_asleep, PLII_SAVED, "3B"),
    PLII_STATE_SPAN(pli_rigid, was_touched, needs_reintegration, PLII_SAVED, "2B"),
    PLII_STATE_SPAN(pli_rigid, pose_version, start, PLII_SAVED, "u12f"),
    PLII_STATE_OF(pli_rigid, path, PLII_SAVED, "18fuB15f2BX24f"),
    PLII_STATE_SPAN(pli_rigid, step_bounds, sleep_group, PLII_SAVED, "9fu"),
    PLII_STATE_SPAN(pli_rigid, rest_pose, rest_time, PLII_SAVED, "13f"),
    {0},
};

/* With the numbers as they are: what the creating functions derive may differ in the last bit. */
static pli_shape* file_make_shape(plii_file* file, plii_shape_kind kind, const float* d) {
    pli_shape* shape = NULL;
    pli_status status = PLI_ERROR_FILE_FORMAT;
    const pli_vec3 v = {d[0], d[1], d[2]};
    if (kind == PLII_SHAPE_PLANE) { status = pli_shape_create_plane(file->context, v, d[3], &shape); }
    if (kind == PLII_SHAPE_SPHERE) { status = pli_shape_create_sphere(file->context, d[0], &shape); }
    if (kind == PLII_SHAPE_BOX) { status = pli_shape_create_box(file->context, v, &shape); }
    if (kind == PLII_SHAPE_CAPSULE) { status = pli_shape_create_capsule(file->context, v, d[4], &shape); }
    if (kind == PLII_SHAPE_CYLINDER) {
        status = pli_shape_create_cylinder(file->context, pli_vec3_scale(v, d[3]), d[4], &shape);
    }
    if (!plii_file_is_made(file, status, "a shape cannot be made of its numbers")) { return NULL; }
    memcpy(shape->def.user, d, shape->data_size);
    return shape;
}

/* The caller's shape of an id, with a reference more. */
static pli_shape* file_find_shape(plii_file* file, uint64_t id) {
    pli_shape* shape = file->def.find_shape != NULL ? file->def.find_shape(id, file->def.user) : NULL;
    if (shape == NULL) {
        PLII_FILE_FAIL(file, PLI_ERROR_INVALID_VALUE,
                       "rigid body %d has a shape of the caller, of id %llu, that find_shape does not give",
                       file->rigid_index, (unsigned long long)id);
        return NULL;
    }
    file->status =
        plii_check_handle(shape, PLII_HANDLE_SHAPE, file->context, "the shape of find_shape", file->function);
    if (file->status != PLI_OK) { return NULL; }
    plii_shape_retain(shape);
    return shape;
}

/* What a shape is. Where it is wanted, one of its own reference; NULL on error. */
static pli_shape* file_shape(plii_file* file, const pli_shape* written, bool is_wanted) {
    int kind = written != NULL ? (int)written->kind : 0;
    plii_file_fields(file, "e5", &kind);
    if (kind == PLII_SHAPE_OTHER) {
        const bool is_asked = file->mode == PLII_FILE_WRITE && file->def.shape_id != NULL;
        const uint64_t id = plii_file_u64(file, is_asked ? file->def.shape_id(written, file->def.user) : 0);
        return is_wanted && file->status == PLI_OK ? file_find_shape(file, id) : NULL;
    }
    float numbers[FILE_SHAPE_NUMBERS] = {0};
    if (written != NULL) { memcpy(numbers, written->def.user, written->data_size); }
    plii_file_fields(file, "8f", numbers);
    if (!is_wanted || file->status != PLI_OK) { return NULL; }
    for (int i = 0; i < FILE_SHAPE_NUMBERS; ++i) {
        if (!plii_is_finite(numbers[i])) { plii_file_refuse(file, "a shape has an infinite number"); }
    }
    return file->status == PLI_OK ? file_make_shape(file, (plii_shape_kind)kind, numbers) : NULL;
}

/* Shape `slot` of the rigid body, after those before it: where it was first, and if that is here, what it is. */
static pli_shape* file_shape_at(plii_file* file, const pli_world* world, int slot, pli_shape* const* shapes,
                                bool is_wanted) {
    const int index = file->rigid_index;
    const pli_shape* written = file->mode != PLII_FILE_READ ? shapes[slot] : NULL;
    const plii_file_identity first = plii_file_identify(file, written);
    int place[2] = {(int)first.index, (int)first.shape};
    plii_file_fields(file, "2i", place);
    if (place[0] == index && place[1] == slot) { return file_shape(file, written, is_wanted); }
    if (file->mode != PLII_FILE_READ || file->status != PLI_OK) { return NULL; }
    const bool is_here = place[0] == index && place[1] >= 0 && place[1] < slot;
    const bool is_before =
        place[0] >= 0 && place[0] < index && place[1] >= 0 && place[1] < world->rigids[place[0]]->shape_count;
    if (!is_here && !is_before) {
        plii_file_refuse(file, "a shape is out of range");
        return NULL;
    }
    if (!is_wanted) { return NULL; }
    pli_shape* shape = is_here ? shapes[place[1]] : world->rigids[place[0]]->shapes[place[1]];
    plii_shape_retain(shape);
    return shape;
}

static void file_copy_parts(const plii_state_part* parts, pli_rigid* to, const pli_rigid* from) {
    for (const plii_state_part* part = parts; part->size > 0; ++part) {
        memcpy((unsigned char*)to + part->offset, (const unsigned char*)from + part->offset, part->size);
    }
}

/* Kept as it is: what is made of a definition is not always its bits. */
static pli_rigid* file_make_rigid(plii_file* file, pli_world* world, const pli_rigid* read) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = read->kind;
    def.state = read->state;
    def.friction = read->friction;
    def.restitution = read->restitution;
    def.linear_factor = read->linear_factor;
    def.angular_factor = read->angular_factor;
    def.shape_count = read->shape_count;
    def.shapes = read->shapes;
    def.shape_poses = read->shape_poses;
    pli_rigid* made = NULL;
    const pli_status status = pli_rigid_create(world, &def, &made);
    if (!plii_file_is_made(file, status, "a rigid body cannot be made of its numbers")) { return NULL; }
    file_copy_parts(file_rigid_first_parts, made, read);
    return made;
}

static void file_rigid_shapes(plii_file* file, const pli_world* world, int count, pli_shape** shapes,
                              pli_transform* poses, bool is_wanted) {
    for (int k = 0; k < count && file->status == PLI_OK; ++k) {
        pli_shape* made = file_shape_at(file, world, k, shapes, is_wanted);
        if (is_wanted) { shapes[k] = made; }
        pli_transform none;
        plii_file_fields(file, "12f", is_wanted || file->mode != PLII_FILE_READ ? &poses[k] : &none);
    }
}

static void file_read_rigid(plii_file* file, pli_world* world, const pli_rigid* source) {
    pli_rigid read = {0};
    plii_file_parts(file, file_rigid_first_parts, &read);
    const int count = plii_file_count(file, 0, 8 + 48);
    const bool is_wanted = source == NULL;
    pli_shape** shapes = NULL;
    pli_transform* poses = NULL;
    if (is_wanted && count > 0 &&
        (!PLII_ALLOCATE(file->context, &shapes, count) || !PLII_ALLOCATE(file->context, &poses, count))) {
        PLII_FILE_FAIL(file, PLI_ERROR_OUT_OF_MEMORY, "no memory for %d shapes", count);
    }
    file_rigid_shapes(file, world, count, shapes, poses, is_wanted);
    if (file->status == PLI_OK && source != NULL && source->shape_count != count) {
        PLII_FILE_FAIL(file, PLI_ERROR_INVALID_VALUE,
                       "the world does not fit the file: rigid body %d has %d shapes, %d in the file",
                       file->rigid_index, source->shape_count, count);
    }
    read.shape_count = count;
    read.shapes = is_wanted ? shapes : source->shapes;
    read.shape_poses = is_wanted ? poses : source->shape_poses;
    pli_rigid* rigid = file->status == PLI_OK ? file_make_rigid(file, world, &read) : NULL;
    if (rigid != NULL) {
        plii_file_parts(file, file_rigid_parts, rigid);
        rigid->is_in_step = true;
    }
    for (int k = 0; k < count && shapes != NULL; ++k) {
        if (shapes[k] != NULL) { plii_shape_release(shapes[k]); }
    }
    PLII_RELEASE(file->context, shapes, count);
    PLII_RELEASE(file->context, poses, count);
}

void plii_file_rigid(plii_file* file, pli_world* world, int index, const pli_rigid* source) {
    plii_file_begin_part(file, "rigid bodies");
    file->rigid_index = index;
    if (file->mode == PLII_FILE_READ) {
        file_read_rigid(file, world, source);
    } else {
        pli_rigid* rigid = world->rigids[index];
        plii_file_parts(file, file_rigid_first_parts, rigid);
        (void)plii_file_count(file, rigid->shape_count, 1);
        file_rigid_shapes(file, world, rigid->shape_count, rigid->shapes, rigid->shape_poses, false);
        plii_file_parts(file, file_rigid_parts, rigid);
    }
    file->what = NULL;
}

/* What the sleep of bodies changes as it is enabled. */
void plii_file_rigid_end(plii_file* file, pli_rigid* rigid) {
    plii_file_fields(file, "B", &rigid->has_changed);
    plii_file_fields(file, "u", &rigid->seen_version);
}

void plii_file_copy_rigid(pli_rigid* to, const pli_rigid* from) {
    file_copy_parts(file_rigid_first_parts, to, from);
    file_copy_parts(file_rigid_parts, to, from);
    to->has_changed = from->has_changed;
    to->seen_version = from->seen_version;
    to->path.next = NULL;
    to->is_in_step = true;
    to->are_shapes_placed = false;
}
