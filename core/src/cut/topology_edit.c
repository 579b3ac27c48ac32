/* The common part of all cuts: the working copy of a body, splitting of links and faces in the order of
   btSoftBody::refine, and the commit, in which everything that can fail comes before the first change of the body. */

#include "cut/topology_edit.h"
#include "body/pipeline.h"

// ----------------------------------------------------------------------------------------------------- life

static void edit_close(plii_edit* edit) {
    PLII_RELEASE(edit->context, edit->nodes, edit->node_capacity);
    PLII_RELEASE(edit->context, edit->links, edit->link_capacity);
    PLII_RELEASE(edit->context, edit->faces, edit->face_capacity);
    plii_scratch_free(&edit->scratch);
    plii_topology_release(edit->context, edit->old_topology);
    plii_walk_end(&edit->walk);
}

pli_status plii_edit_open(pli_body* body, const char* function, plii_edit* edit) {
    plii_topology* topology = body->topology;
    *edit = (plii_edit){
        .body = body,
        .context = body->context,
        .function = function,
        .old_topology = topology,
        .old_node_count = body->node_count,
        .old_link_count = body->link_count,
        .node_count = body->node_count,
        .link_count = body->link_count,
        .face_count = topology->face_count,
        .scratch.context = body->context,
    };
    ++topology->reference_count;
    plii_walk_begin(&edit->walk, edit->context, PLII_WALK_STEP);
    if (!PLII_RESERVE(edit->context, &edit->nodes, &edit->node_capacity, edit->node_count) ||
        !PLII_RESERVE(edit->context, &edit->links, &edit->link_capacity, edit->link_count) ||
        !PLII_RESERVE(edit->context, &edit->faces, &edit->face_capacity, edit->face_count)) {
        edit_close(edit);
        return plii_fail(body->context, PLI_ERROR_OUT_OF_MEMORY, function,
                         "no memory for a copy of %d nodes, %d links and %d faces", body->node_count, body->link_count,
                         topology->face_count);
    }
    for (int i = 0; i < edit->node_count; ++i) {
        edit->nodes[i].position = body->positions[i];
        edit->nodes[i].previous = body->previous[i];
        edit->nodes[i].velocity = body->velocities[i];
    }
    for (int i = 0; i < edit->link_count; ++i) {
        edit->links[i] = (plii_edit_link){
            .nodes = {body->links[i].nodes[0], body->links[i].nodes[1]},
            .rest_squared = body->links[i].rest_length_squared,
            .tag = body->link_tags != NULL ? body->link_tags[i] : (plii_link_tag)0,
        };
    }
    for (int i = 0; i < edit->face_count; ++i) {
        plii_edit_face* face = &edit->faces[i];
        memcpy(face->nodes, topology->faces[i], sizeof face->nodes);
        face->material = topology->face_materials != NULL ? topology->face_materials[i] : (uint16_t)0;
        face->origin = (plii_face_origin){i, 1.0f};
    }
    return PLI_OK;
}

pli_status plii_edit_check_tetras(const plii_edit* edit, plii_edit_tetra_fn* is_met, const void* user,
                                  const char* how) {
    for (int i = 0; i < edit->old_topology->tetra_count; ++i) {
        if (!is_met(edit->old_topology->tetras[i], user)) { continue; }
        return plii_fail(edit->context, PLI_ERROR_INVALID_MESH, edit->function,
                         "%s tetrahedron %d, tetrahedra cannot be cut", how, i);
    }
    return PLI_OK;
}

// -------------------------------------------------------------------------------------------------- elements

/* Both parents make the new node as heavy as the point between them; next to a pinned one the other gives half. Of
   inverse masses. */
static float edit_split_mass(float* a, float* b, float share) {
    if (*a > 0.0f && *b > 0.0f) {
        const float mass_a = 1.0f / *a, mass_b = 1.0f / *b;
        const float mass = mass_a + (mass_b - mass_a) * share;
        const float scale = (mass_a + mass_b) / (mass_a + mass_b + mass);
        *a = 1.0f / (mass_a * scale);
        *b = 1.0f / (mass_b * scale);
        return 1.0f / (mass * scale);
    }
    float* giver = *a > 0.0f ? a : b;
    if (!(*giver > 0.0f)) { return 0.0f; }
    *giver /= 0.5f;
    return 1.0f / (1.0f / *giver);
}

static pli_vec4 edit_lerp(pli_vec4 a, pli_vec4 b, float share, float limit) {
    const pli_vec3 between = plii_vec3_clamp(pli_vec3_lerp(plii_xyz(a), plii_xyz(b), share), limit);
    return (pli_vec4){between.x, between.y, between.z, 0.0f};
}

/* Room for one more node, link or face. */
#define EDIT_GROW(edit, element)                                                                                       \
    PLII_EDIT_GROW(edit, &(edit)->element##s, &(edit)->element##_capacity, (edit)->element##_count)

int plii_edit_add_node(plii_edit* edit, int a, int b, float share) {
    if (!EDIT_GROW(edit, node)) { return 0; }
    plii_edit_node *first = &edit->nodes[a], *second = &edit->nodes[b];
    plii_edit_node* node = &edit->nodes[edit->node_count];
    node->position = edit_lerp(first->position, second->position, share, PLI_MAX_COORDINATE);
    node->previous = edit_lerp(first->previous, second->previous, share, PLI_MAX_COORDINATE);
    node->velocity = edit_lerp(first->velocity, second->velocity, share, PLI_MAX_SPEED);
    node->position.w = edit_split_mass(&first->position.w, &second->position.w, share);
    node->origin = (plii_node_origin){a, b, share};
    return edit->node_count++;
}

int plii_edit_copy_node(plii_edit* edit, int source) {
    if (!EDIT_GROW(edit, node)) { return 0; }
    plii_edit_node* old = &edit->nodes[source];
    plii_edit_node* node = &edit->nodes[edit->node_count];
    *node = *old;
    if (old->position.w > 0.0f) {
        node->position.w = 1.0f / (1.0f / old->position.w * 0.5f);
        old->position.w /= 0.5f;
    }
    node->origin = (plii_node_origin){source, source, 0.0f};
    return edit->node_count++;
}

void plii_edit_add_link(plii_edit* edit, plii_edit_link link) {
    if (EDIT_GROW(edit, link)) { edit->links[edit->link_count++] = link; }
}

void plii_edit_add_face(plii_edit* edit, plii_edit_face face) {
    if (EDIT_GROW(edit, face)) { edit->faces[edit->face_count++] = face; }
}

plii_edge* plii_edit_add_edge(plii_edit* edit, plii_edge_map* map, int a, int b) {
    plii_edge* edge = plii_edge_map_add(map, a, b);
    if (edge != NULL) { return edge; }
    edit->scratch.is_short = true;
    edit->spare = (plii_edge){.node = PLI_NULL_INDEX, .first = PLI_NULL_INDEX};
    return &edit->spare;
}

void plii_edit_split_link(plii_edit* edit, int link, int from, float share, int near, int far) {
    plii_edit_link half = edit->links[link];
    const bool is_forward = half.nodes[0] == from;
    const float kept = is_forward ? share : 1.0f - share;
    half.nodes[0] = is_forward ? far : near;
    half.rest_squared = (1.0f - kept) * (1.0f - kept) * edit->links[link].rest_squared;
    plii_edit_add_link(edit, half);
    edit->links[link].nodes[1] = is_forward ? near : far;
    edit->links[link].rest_squared = kept * kept * edit->links[link].rest_squared;
}

void plii_edit_remove_links(plii_edit* edit, plii_edit_link_fn* goes, void* user) {
    for (int i = 0; i < edit->link_count;) {
        if (goes(&edit->links[i], user)) {
            edit->links[i] = edit->links[--edit->link_count];
        } else {
            ++i;
        }
    }
}

// ---------------------------------------------------------------------------------------------- rest lengths

static float edit_distance_squared(const plii_edit* edit, int a, int b) {
    return pli_vec3_length_squared(pli_vec3_sub(plii_edit_position(edit, a), plii_edit_position(edit, b)));
}

static float edit_rest_squared(const plii_edit* edit, const plii_edge_map* map, int a, int b) {
    const plii_edge* edge = plii_edge_map_find(map, a, b);
    return edge != NULL && edge->rest_squared >= 0.0f ? edge->rest_squared : edit_distance_squared(edit, a, b);
}

float plii_edit_median_squared(const plii_edit* edit, const plii_edge_map* map, int node, int b, int c, float share) {
    const float ab_squared = edit_rest_squared(edit, map, node, b), ac_squared = edit_rest_squared(edit, map, node, c);
    const float bc_squared = edit_rest_squared(edit, map, b, c);
    const float squared = (1.0f - share) * ab_squared + share * ac_squared - share * (1.0f - share) * bc_squared;
    /* Rest lengths that make no triangle. */
    return plii_max(squared, 0.0f);
}

void plii_edit_learn(plii_edit* edit, plii_edge_map* map) {
    for (PLII_EACH(const plii_edit_face, face, edit->faces, edit->face_count)) {
        bool is_crossed = false;
        for (int j = 2, k = 0; k < 3; j = k++) {
            is_crossed = is_crossed || plii_edge_map_node(map, face->nodes[j], face->nodes[k]) != PLI_NULL_INDEX;
        }
        for (int j = 2, k = 0; is_crossed && k < 3; j = k++) {
            (void)plii_edit_add_edge(edit, map, face->nodes[j], face->nodes[k]);
        }
    }
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        plii_edge* edge = plii_edge_map_find(map, link->nodes[0], link->nodes[1]);
        if (edge == NULL || edge->rest_squared >= 0.0f || plii_edit_link_is_bending(link)) { continue; }
        edge->rest_squared = link->rest_squared;
    }
}

// -------------------------------------------------------------------------------------------------- splitting

static void edit_split_links(plii_edit* edit, const plii_edge_map* map) {
    const int count = edit->link_count;
    for (int i = 0; i < count; ++i) {
        const int* nodes = edit->links[i].nodes;
        const plii_edge* edge = plii_edge_map_find(map, nodes[0], nodes[1]);
        if (edge == NULL || edge->node == PLI_NULL_INDEX) { continue; }
        plii_edit_split_link(edit, i, edge->a, edge->share, edge->node, edge->node);
    }
}

/* Parts face i at the node on its edge from corner j to corner k. */
static void edit_split_face(plii_edit* edit, plii_edge_map* map, int i, int j, int k, plii_edge edge) {
    const plii_edit_face face = edit->faces[i];
    const int from = face.nodes[j], to = face.nodes[k], opposite = face.nodes[(k + 1) % 3];
    const float share = from == edge.a ? edge.share : 1.0f - edge.share;
    const plii_edit_face first = {
        {opposite, from, edge.node}, face.material, {face.origin.parent, face.origin.share * share}};
    const plii_edit_face second = {
        {edge.node, to, opposite}, face.material, {face.origin.parent, face.origin.share * (1.0f - share)}};
    edit->faces[i] = first;
    plii_edit_add_face(edit, second);
    const float edge_squared = edit_rest_squared(edit, map, from, to);
    const float rest_squared = plii_edit_median_squared(edit, map, opposite, from, to, share);
    const plii_edit_link link = {{edge.node, opposite}, rest_squared, (plii_link_tag)face.material};
    plii_edit_add_link(edit, link);
    plii_edit_add_edge(edit, map, edge.node, opposite)->rest_squared = rest_squared;
    plii_edit_add_edge(edit, map, from, edge.node)->rest_squared = share * share * edge_squared;
    plii_edit_add_edge(edit, map, edge.node, to)->rest_squared = (1.0f - share) * (1.0f - share) * edge_squared;
}

static void edit_split_faces(plii_edit* edit, plii_edge_map* map) {
    for (int i = 0; i < edit->face_count && map->count > 0; ++i) {
        /* A face is looked at again after each split. */
        for (int j = 2, k = 0; k < 3;) {
            const int* nodes = edit->faces[i].nodes;
            const plii_edge* edge = plii_edge_map_find(map, nodes[j], nodes[k]);
            if (edge == NULL || edge->node == PLI_NULL_INDEX) {
                j = k++;
                continue;
            }
            edit_split_face(edit, map, i, j, k, *edge);
            j = 2;
            k = 0;
        }
    }
}

void plii_edit_split(plii_edit* edit, plii_edge_map* map) {
    plii_edit_learn(edit, map);
    edit_split_links(edit, map);
    edit_split_faces(edit, map);
}

// ----------------------------------------------------------------------------------------------------- commit

/* The body's new arrays and what features asked for, until they are handed over. */
typedef struct edit_product {
    pli_body body; /* only its arrays and their counts */
    plii_scratch scratch;
    struct edit_blocks {
        void* blocks[PLII_MAX_FEATURE_ARRAYS];
        size_t sizes[PLII_MAX_FEATURE_ARRAYS];
    } * features; /* [feature_count] */
} edit_product;

static bool edit_make_topology(const plii_edit* edit, edit_product* product, plii_face_origin* origins) {
    const plii_topology* old = edit->old_topology;
    plii_topology* topology =
        plii_topology_create(edit->context, edit->face_count, old->tetra_count, old->face_materials != NULL);
    product->body.topology = topology;
    if (topology == NULL) { return false; }
    for (int i = 0; i < edit->face_count; ++i) {
        memcpy(topology->faces[i], edit->faces[i].nodes, sizeof topology->faces[i]);
        if (topology->face_materials != NULL) { topology->face_materials[i] = edit->faces[i].material; }
        origins[i] = edit->faces[i].origin;
    }
    if (old->tetra_count > 0) { memcpy(topology->tetras, old->tetras, (size_t)old->tetra_count * sizeof *old->tetras); }
    return true;
}

/* With what the change says of it. */
static bool edit_make_product(const plii_edit* edit, edit_product* product, plii_topology_change* change) {
    pli_body* fresh = &product->body;
    fresh->context = product->scratch.context = edit->context;
    fresh->node_count = edit->node_count;
    fresh->link_count = edit->link_count;
    const int old_node_count = edit->old_node_count;
    plii_node_origin* origins = PLII_TAKE(&product->scratch, plii_node_origin, edit->node_count - old_node_count);
    plii_face_origin* face_origins = PLII_TAKE(&product->scratch, plii_face_origin, edit->face_count);
    product->features = PLII_TAKE(&product->scratch, struct edit_blocks, edit->body->pipeline.feature_count);
    bool needs_tags = false;
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        needs_tags = needs_tags || link->tag != 0;
    }
    if (product->scratch.is_short || !plii_body_allocate_arrays(fresh, needs_tags) ||
        !edit_make_topology(edit, product, face_origins)) {
        return false;
    }
    change->node_origins = origins;
    change->face_origins = face_origins;
    change->faces = (const int(*)[3])fresh->topology->faces;
    for (int i = 0; i < edit->node_count; ++i) {
        fresh->positions[i] = edit->nodes[i].position;
        fresh->previous[i] = edit->nodes[i].previous;
        fresh->velocities[i] = edit->nodes[i].velocity;
        if (i >= old_node_count) { origins[i - old_node_count] = edit->nodes[i].origin; }
    }
    for (int i = 0; i < edit->link_count; ++i) {
        const plii_edit_link* link = &edit->links[i];
        fresh->links[i] = (plii_link){{link->nodes[0], link->nodes[1]}, link->rest_squared};
        if (edit->takes_rest_shape) {
            const float length = sqrtf(edit_distance_squared(edit, link->nodes[0], link->nodes[1]));
            fresh->links[i].rest_length_squared = length * length;
        }
        if (fresh->link_tags != NULL) { fresh->link_tags[i] = link->tag; }
    }
    return true;
}

static bool edit_reserve_features(const plii_edit* edit, const plii_topology_change* change, edit_product* product) {
    const plii_pipeline* pipeline = &edit->body->pipeline;
    for (int i = 0; i < pipeline->feature_count; ++i) {
        const plii_feature_class* klass = pipeline->features[i].klass;
        void* state = pipeline->features[i].state;
        struct edit_blocks* wanted = &product->features[i];
        const int count = plii_feature_arrays_sizes(klass, change, wanted->sizes);
        if (klass->topology_reserve != NULL && !klass->topology_reserve(edit->body, state, change)) { return false; }
        for (int k = 0; k < count; ++k) {
            if (!plii_allocate_array(edit->context, &wanted->blocks[k], wanted->sizes[k])) { return false; }
        }
    }
    return true;
}

static void edit_replace(pli_body* body, const pli_body* fresh) {
    plii_body_release_arrays(body);
    body->positions = fresh->positions;
    body->previous = fresh->previous;
    body->velocities = fresh->velocities;
    body->links = fresh->links;
    body->link_tags = fresh->link_tags;
    body->topology = fresh->topology;
    body->node_count = fresh->node_count;
    body->link_count = fresh->link_count;
    body->link_revision += 1;
    body->length_revision += 1;
}

static pli_status edit_commit(plii_edit* edit) {
    pli_body* body = edit->body;
    for (PLII_EACH_FEATURE(feature, body)) {
        const plii_feature_class* klass = feature->klass;
        /* What keeps memory by the size of the body has to say how it follows. */
        if (klass->topology_commit != NULL || klass->build != NULL || !plii_feature_arrays_need_commit(klass)) {
            continue;
        }
        return plii_fail(edit->context, PLI_ERROR_WRONG_STATE, edit->function, "%s cannot follow a cut of the body",
                         klass->name);
    }
    edit_product product = {0};
    plii_topology_change change = {
        .old_node_count = edit->old_node_count,
        .old_link_count = edit->old_link_count,
        .old_face_count = edit->old_topology->face_count,
        .old_faces = (const int(*)[3])edit->old_topology->faces,
        .node_count = edit->node_count,
        .link_count = edit->link_count,
        .face_count = edit->face_count,
        .takes_rest_shape = edit->takes_rest_shape,
    };
    if (!edit_make_product(edit, &product, &change) || !edit_reserve_features(edit, &change, &product)) {
        plii_body_release_arrays(&product.body);
        for (int i = 0; product.features != NULL && i < body->pipeline.feature_count; ++i) {
            for (int k = 0; k < PLII_MAX_FEATURE_ARRAYS; ++k) {
                plii_release(edit->context, product.features[i].blocks[k], product.features[i].sizes[k]);
            }
        }
        plii_scratch_free(&product.scratch);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    edit_replace(body, &product.body);
    body->world->needs_reserve = true;
    for (int i = 0; i < body->pipeline.feature_count; ++i) {
        const plii_feature_class* klass = body->pipeline.features[i].klass;
        void *state = body->pipeline.features[i].state, **blocks = product.features[i].blocks;
        plii_feature_arrays_exchange(body, klass, state, &change, blocks);
        change.old_arrays = blocks;
        if (klass->topology_commit != NULL) { klass->topology_commit(body, state, &change); }
        if (klass->build != NULL) { klass->build(body, state); }
        plii_feature_arrays_drop(body, klass, state, &change, blocks);
    }
    plii_scratch_free(&product.scratch);
    plii_body_refresh(body);
    plii_features_notify(body->world, PLII_TOPOLOGY_CHANGED, body);
    return PLI_OK;
}

pli_status plii_edit_end(plii_edit* edit, pli_status status) {
    if (status == PLI_OK && edit->scratch.is_short) { status = PLI_ERROR_OUT_OF_MEMORY; }
    if (status == PLI_OK && !edit->is_unchanged) { status = edit_commit(edit); }
    if (status == PLI_ERROR_OUT_OF_MEMORY) {
        plii_fail(edit->context, status, edit->function, "no memory to cut %d nodes, %d links and %d faces",
                  edit->old_node_count, edit->old_link_count, edit->old_topology->face_count);
    }
    edit_close(edit);
    return status;
}
