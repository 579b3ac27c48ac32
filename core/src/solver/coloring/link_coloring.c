/* Colours of links: quads in the order in which they were found, then links that are in none, each with the lowest
   colour that is free at its nodes, one whose last group has lanes left before others. Linear time. */

#include "solver/coloring/link_coloring.h"

#include "base/csr.h"
#include "math/simd_float8.h"

#include <string.h>

enum {
    LINK_COLORS_MAX = 64,
    LINK_COLORS_QUADS_NODES = 80 /* a smaller body has too few quads for their colours */
};

/* Quads and single links in one order: index of a quad, or quad count + index of a single link. */
typedef struct link_colors_work {
    const pli_body* body;
    int node_count, link_count, tag_count; /* tags as key: material, then bending */
    plii_link_quads quads;
    uint64_t* masks;     /* [node_count] colours of the links around */
    uint64_t* open;      /* [tag_count] colours whose last group of that tag has lanes left */
    uint8_t* lanes;      /* [tag_count][LINK_COLORS_MAX] how many it has taken */
    int* counts;         /* [max(node_count, tag_count) + 1] */
    int *order, *sorted; /* [link_count] */
    int count;           /* of them */
    uint8_t* colors;     /* [link_count] of those */
    int* serial_links;   /* [link_count] */
    uint8_t* kinds;      /* [link_count] pairs of the group of each of those */
} link_colors_work;

/* A quad or a single link: what a lane of a group gets. */
typedef struct link_colors_item {
    int nodes[4], links[PLII_LINK_PAIRS]; /* or PLI_NULL_INDEX */
    uint8_t pairs;
} link_colors_item;

// ---------------------------------------------------------------------------------------------------------- storage

/* Parts of one block of memory; with base NULL only the size is taken. */
typedef struct link_colors_carver {
    char* base;
    size_t used;
} link_colors_carver;

static void* link_colors_carve(link_colors_carver* carver, size_t size) {
    const size_t at = carver->used;
    carver->used += (size + 63) / 64 * 64;
    return carver->base != NULL ? carver->base + at : NULL;
}

static void link_colors_carve_result(link_colors_carver* carver, plii_link_colors* colors) {
    colors->colors = link_colors_carve(carver, (size_t)colors->color_count * sizeof *colors->colors);
    colors->groups = link_colors_carve(carver, (size_t)colors->group_count * sizeof *colors->groups);
    colors->scaled_indices =
        link_colors_carve(carver, (size_t)colors->scaled_index_count * sizeof *colors->scaled_indices);
    colors->row_links = link_colors_carve(carver, (size_t)colors->row_count * sizeof *colors->row_links);
    colors->serial_links = link_colors_carve(carver, (size_t)colors->serial_count * sizeof *colors->serial_links);
}

static void link_colors_carve_work(link_colors_carver* carver, link_colors_work* work) {
    const size_t nodes = (size_t)work->node_count, links = (size_t)work->link_count, tags = (size_t)work->tag_count;
    plii_link_quads* quads = &work->quads;
    work->serial_links = link_colors_carve(carver, links * sizeof *work->serial_links);
    work->kinds = link_colors_carve(carver, links * sizeof *work->kinds);
    quads->quads = link_colors_carve(carver, links / 3 * sizeof *quads->quads);
    quads->links = link_colors_carve(carver, links * sizeof *quads->links);
    quads->halves = link_colors_carve(carver, 2 * links * sizeof *quads->halves);
    quads->begin = link_colors_carve(carver, (nodes + 1) * sizeof *quads->begin);
    quads->open = link_colors_carve(carver, nodes * sizeof *quads->open);
    quads->marks = link_colors_carve(carver, nodes * sizeof *quads->marks);
    quads->is_used = link_colors_carve(carver, links * sizeof *quads->is_used);
    work->masks = link_colors_carve(carver, nodes * sizeof *work->masks);
    work->open = link_colors_carve(carver, tags * sizeof *work->open);
    work->lanes = link_colors_carve(carver, LINK_COLORS_MAX * tags * sizeof *work->lanes);
    work->counts = link_colors_carve(carver, ((nodes > tags ? nodes : tags) + 1) * sizeof *work->counts);
    work->order = link_colors_carve(carver, links * sizeof *work->order);
    work->sorted = link_colors_carve(carver, links * sizeof *work->sorted);
    work->colors = link_colors_carve(carver, links * sizeof *work->colors);
}

static link_colors_work link_colors_work_of(const pli_body* body, int node_count, int link_count) {
    return (link_colors_work){
        .body = body, .node_count = node_count, .link_count = link_count, .tag_count = 2 * body->material_count};
}

static size_t link_colors_work_size(const pli_body* body, int node_count, int link_count) {
    link_colors_work work = link_colors_work_of(body, node_count, link_count);
    link_colors_carver carver = {0};
    link_colors_carve_work(&carver, &work);
    return carver.used;
}

// ------------------------------------------------------------------------------------------------------------- items

static const int* link_colors_links_at(const link_colors_work* work, int index) {
    const plii_link_quads* quads = &work->quads;
    return &quads->links[index < quads->quad_count ? quads->quads[index].first_link
                                                   : quads->in_quads + index - quads->quad_count];
}
static plii_link_tag link_colors_tag_at(const link_colors_work* work, int index) {
    return plii_link_tag_of(work->body, *link_colors_links_at(work, index));
}
static uint8_t link_colors_pairs_at(const link_colors_work* work, int index) {
    return index < work->quads.quad_count ? work->quads.quads[index].pairs : PLII_LINK_SINGLE;
}

static link_colors_item link_colors_item_at(const link_colors_work* work, int index) {
    const int* link = link_colors_links_at(work, index);
    const bool is_quad = index < work->quads.quad_count;
    const int* nodes = is_quad ? work->quads.quads[index].nodes : work->body->links[*link].nodes;
    link_colors_item item = {.pairs = link_colors_pairs_at(work, index)};
    for (int k = 0; k < 4; ++k) {
        item.nodes[k] = nodes[is_quad || k == 1 ? k : 0];
    }
    for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
        item.links[k] = (item.pairs >> k & 1) != 0 ? *link++ : PLI_NULL_INDEX;
    }
    return item;
}

static int link_colors_link_count(uint8_t pairs) {
    int count = 0;
    for (; pairs != 0; pairs = (uint8_t)(pairs & (pairs - 1))) {
        ++count;
    }
    return count;
}

static int link_colors_tag_key(const link_colors_work* work, int index) {
    const int tag = link_colors_tag_at(work, index);
    return 2 * (tag & (PLII_LINK_TAG_BENDING - 1)) + ((tag & PLII_LINK_TAG_BENDING) != 0);
}

/* One bit, that of the colour which an item gets at nodes whose colours are `used`; 0 when none is free. */
static uint64_t link_colors_take_color(link_colors_work* work, int index, uint64_t used) {
    const int tag = link_colors_tag_key(work, index);
    const uint64_t open = ~used & work->open[tag], free = open != 0 ? open : ~used;
    const uint64_t lowest = free & (~free + 1);
    if (lowest == 0) { return 0; }
    uint8_t color = 0;
    for (uint64_t bit = lowest; bit > 1; bit >>= 1) {
        ++color;
    }
    work->colors[index] = color;
    uint8_t* lanes = &work->lanes[LINK_COLORS_MAX * tag + color];
    *lanes = (uint8_t)((*lanes + 1) % PLII_LINK_LANES);
    work->open[tag] = *lanes != 0 ? work->open[tag] | lowest : work->open[tag] & ~lowest;
    return lowest;
}

/* Lists what gets a colour in `order`, the links of the rest as serial. */
static int link_colors_assign(link_colors_work* work) {
    const plii_link_quads* quads = &work->quads;
    const int item_count = quads->quad_count + quads->single_count;
    int serial_count = 0;
    for (int i = 0; i < item_count; ++i) {
        const link_colors_item item = link_colors_item_at(work, i);
        uint64_t used = 0;
        for (int k = 0; k < 4; ++k) {
            used |= work->masks[item.nodes[k]];
        }
        const uint64_t color = link_colors_take_color(work, i, used);
        if (color == 0) {
            for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
                if (item.links[k] != PLI_NULL_INDEX) { work->serial_links[serial_count++] = item.links[k]; }
            }
            continue;
        }
        for (int k = 0; k < 4; ++k) {
            work->masks[item.nodes[k]] |= color;
        }
        work->order[work->count++] = i;
    }
    return serial_count;
}

// -------------------------------------------------------------------------------------------------------------- sort

typedef int link_colors_key_fn(const link_colors_work* work, int index);

static int link_colors_by_node(const link_colors_work* work, int index) {
    const link_colors_item item = link_colors_item_at(work, index);
    int low = item.nodes[0];
    for (int k = 1; k < 4; ++k) {
        low = item.nodes[k] < low ? item.nodes[k] : low;
    }
    return low;
}
static int link_colors_by_pairs(const link_colors_work* work, int index) {
    return (1 << PLII_LINK_PAIRS) - 1 - link_colors_pairs_at(work, index);
}
static int link_colors_by_color(const link_colors_work* work, int index) {
    return work->colors[index];
}

/* Stable. */
static void link_colors_sort(link_colors_work* work, link_colors_key_fn* key, int key_count) {
    int counts_of_few[(1 << PLII_LINK_PAIRS) + 1];
    int* begin = key_count > 1 << PLII_LINK_PAIRS ? work->counts : counts_of_few;
    memset(begin, 0, ((size_t)key_count + 1) * sizeof *begin);
    for (int i = 0; i < work->count; ++i) {
        ++begin[key(work, work->order[i])];
    }
    (void)plii_csr_sum(key_count, begin);
    for (int i = work->count - 1; i >= 0; --i) {
        work->sorted[--begin[key(work, work->order[i])]] = work->order[i];
    }
    int* sorted = work->sorted;
    work->sorted = work->order;
    work->order = sorted;
}

// ------------------------------------------------------------------------------------------------------------- kinds

/* Kernels solve groups of a kind together, and have code of its own for two triangles: where one link is missing an
   empty row costs less than a kind of few groups. */
static uint8_t link_colors_group_pairs(uint8_t pairs, int count) {
    const bool lacks_one = (pairs & ~PLII_LINK_TWO_TRIANGLES) == 0 && link_colors_link_count(pairs) == 4;
    return lacks_one && 2 * count >= PLII_LINK_LANES ? PLII_LINK_TWO_TRIANGLES : pairs;
}

/* Items of a group have one colour and tag, and one kind once there are kinds. */
static int link_colors_group_end(const link_colors_work* work, int first) {
    const int lead = work->order[first];
    const plii_link_tag tag = link_colors_tag_at(work, lead);
    int end = first + 1;
    for (; end < work->count && end - first < PLII_LINK_LANES; ++end) {
        const int index = work->order[end];
        if (work->colors[index] != work->colors[lead] || work->kinds[index] != work->kinds[lead] ||
            link_colors_tag_at(work, index) != tag) {
            break;
        }
    }
    return end;
}

static int link_colors_by_kind(const link_colors_work* work, int index) {
    return (1 << PLII_LINK_PAIRS) - 1 - work->kinds[index];
}

/* Brings groups of a colour that have the same pairs together, which kernels solve at once; with several tags they come
   tag by tag otherwise. */
static void link_colors_sort_kinds(link_colors_work* work) {
    for (int first = 0; first < work->count;) {
        const int end = link_colors_group_end(work, first);
        uint8_t kind = 0;
        for (int i = first; i < end; ++i) {
            kind |= link_colors_pairs_at(work, work->order[i]);
        }
        kind = link_colors_group_pairs(kind, end - first);
        for (; first < end; ++first) {
            work->kinds[work->order[first]] = kind;
        }
    }
    link_colors_sort(work, link_colors_by_kind, 1 << PLII_LINK_PAIRS);
    link_colors_sort(work, link_colors_by_color, LINK_COLORS_MAX);
}

// ------------------------------------------------------------------------------------------------------------ groups

/* Adds a group from items [first, end) of one color, tag and kind; with no memory in `made` only to its counts. Lanes
   without an item come first and have the nodes of others. */
static void link_colors_make_group(const link_colors_work* work, int first, int end, plii_link_colors* made) {
    const int count = end - first, empty = PLII_LINK_LANES - count;
    uint8_t pairs = 0;
    for (int i = first; i < end; ++i) {
        pairs |= link_colors_pairs_at(work, work->order[i]);
    }
    pairs = link_colors_group_pairs(pairs, count);
    const int node_count = pairs == PLII_LINK_SINGLE ? 2 : 4;
    if (made->groups != NULL) {
        made->groups[made->group_count] = (plii_link_group){.first_row = made->row_count,
                                                            .first_scaled_index = made->scaled_index_count,
                                                            .tag = link_colors_tag_at(work, work->order[first]),
                                                            .pairs = pairs};
        for (int lane = 0; lane < PLII_LINK_LANES; ++lane) {
            const bool is_empty = lane < empty;
            const link_colors_item item =
                link_colors_item_at(work, work->order[first + (is_empty ? lane % count : lane - empty)]);
            for (int k = 0; k < node_count; ++k) {
                made->scaled_indices[made->scaled_index_count + k][lane] = plii_scaled_index(item.nodes[k]);
            }
            int(*row)[PLII_LINK_LANES] = &made->row_links[made->row_count];
            for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
                if ((pairs >> k & 1) != 0) { (*row++)[lane] = is_empty ? PLI_NULL_INDEX : item.links[k]; }
            }
        }
    }
    made->group_count += 1;
    made->scaled_index_count += node_count;
    made->row_count += link_colors_link_count(pairs);
}

static void link_colors_make_groups(const link_colors_work* work, plii_link_colors* made) {
    for (int first = 0; first < work->count;) {
        const int color = work->colors[work->order[first]], first_group = made->group_count;
        while (first < work->count && work->colors[work->order[first]] == color) {
            const int end = link_colors_group_end(work, first);
            link_colors_make_group(work, first, end, made);
            first = end;
        }
        if (made->groups != NULL) {
            made->colors[made->color_count] = (plii_link_color){first_group, made->group_count - first_group};
        }
        made->color_count += 1;
    }
}

// ------------------------------------------------------------------------------------------------------- the service

/* A full group has eight links or more; of groups that are not full there is one for each colour and tag at most. */
static size_t link_colors_max_groups(const pli_body* body, int link_count) {
    const size_t links = (size_t)link_count;
    const bool has_tags = body->link_tags != NULL || body->material_count > 1; /* links of faces may get one */
    const size_t parts = LINK_COLORS_MAX * (has_tags ? 2 * (size_t)body->material_count : 1);
    return links / PLII_LINK_LANES + (parts < links ? parts : links);
}

/* Bytes that the result can have at most. */
static size_t link_colors_max_bytes(const pli_body* body, int link_count) {
    const int groups = (int)link_colors_max_groups(body, link_count);
    plii_link_colors most = {.color_count = LINK_COLORS_MAX,
                             .group_count = groups,
                             .row_count = PLII_LINK_PAIRS * groups,
                             .scaled_index_count = 4 * groups,
                             .serial_count = link_count};
    link_colors_carver carver = {0};
    link_colors_carve_result(&carver, &most);
    return carver.used;
}

typedef struct link_colors_block {
    void* memory;
    size_t size;
} link_colors_block;

/* `storage` is zeroed and of link_colors_work_size. The result gets a block that just holds it, or without memory takes
   `spare` and clears that; false when there is none. */
static bool link_colors_make(const pli_body* body, void* storage, link_colors_block* spare, plii_link_colors* colors) {
    link_colors_work work = link_colors_work_of(body, body->node_count, body->link_count);
    link_colors_carver carver = {.base = storage};
    link_colors_carve_work(&carver, &work);
    plii_link_quads_find(body, body->node_count >= LINK_COLORS_QUADS_NODES, &work.quads);
    const int serial_count = link_colors_assign(&work);
    link_colors_sort(&work, link_colors_by_node, work.node_count);
    link_colors_sort(&work, link_colors_by_pairs, 1 << PLII_LINK_PAIRS);
    if (body->link_tags != NULL) { link_colors_sort(&work, link_colors_tag_key, work.tag_count); }
    link_colors_sort(&work, link_colors_by_color, LINK_COLORS_MAX);
    if (body->link_tags != NULL) { link_colors_sort_kinds(&work); }

    plii_link_colors made = {0};
    link_colors_make_groups(&work, &made);
    made.serial_count = serial_count;
    carver = (link_colors_carver){0};
    link_colors_carve_result(&carver, &made);
    link_colors_block block = {plii_allocate(body->context, carver.used), carver.used};
    if (block.memory == NULL && carver.used > 0) {
        block = *spare;
        *spare = (link_colors_block){NULL, 0};
        if (block.memory == NULL) { return false; }
    }
    carver = (link_colors_carver){.base = block.memory};
    link_colors_carve_result(&carver, &made);
    *colors = made;
    colors->color_count = colors->group_count = colors->row_count = colors->scaled_index_count = 0;
    link_colors_make_groups(&work, colors);
    if (serial_count > 0) {
        memcpy(colors->serial_links, work.serial_links, (size_t)serial_count * sizeof *colors->serial_links);
    }
    colors->storage = block.memory;
    colors->storage_size = block.size;
    return true;
}

void plii_link_colors_gather(const plii_link_colors* colors, const float* values, int stride, float filler,
                             float* slots) {
    for (int r = 0; r < colors->row_count; ++r) {
        for (int lane = 0; lane < PLII_LINK_LANES; ++lane) {
            const int link = colors->row_links[r][plii_simd_record(lane)];
            *slots++ = link != PLI_NULL_INDEX ? values[(ptrdiff_t)stride * link] : filler;
        }
    }
    for (int i = 0; i < colors->serial_count; ++i) {
        *slots++ = values[(ptrdiff_t)stride * colors->serial_links[i]];
    }
}

bool plii_link_slots_make(const pli_body* body, const plii_link_colors* colors, int width, plii_link_slots* slots) {
    slots->size = (size_t)width * (size_t)plii_link_colors_slot_count(colors) * sizeof *slots->values;
    slots->values = plii_allocate(body->context, slots->size);
    return slots->values != NULL || slots->size == 0;
}

void plii_link_slots_release(const pli_body* body, plii_link_slots* slots) {
    plii_release(body->context, slots->values, slots->size);
    *slots = (plii_link_slots){0};
}

size_t plii_link_slots_max_size(const pli_body* body, int link_count, int width) {
    const size_t slots = PLII_LINK_LANES * PLII_LINK_PAIRS * link_colors_max_groups(body, link_count);
    return (size_t)width * (slots + (size_t)link_count) * sizeof(float);
}

void plii_link_slots_replace(const pli_body* body, const plii_link_colors* colors, int link_count, int width,
                             void* block, plii_link_slots* slots) {
    plii_link_slots_release(body, slots);
    const size_t max_size = plii_link_slots_max_size(body, link_count, width);
    if (plii_link_slots_make(body, colors, width, slots)) {
        plii_release(body->context, block, max_size);
    } else {
        *slots = (plii_link_slots){block, max_size};
    }
}

static pli_status link_colors_enable(pli_body* body, void* state) {
    const size_t size = link_colors_work_size(body, body->node_count, body->link_count);
    void* storage = plii_allocate(body->context, size);
    if (storage == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    link_colors_block spare = {NULL, 0};
    const bool is_made = link_colors_make(body, storage, &spare, state);
    plii_release(body->context, storage, size);
    return is_made ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static const plii_feature_array link_colors_arrays[] = {
    {PLII_BLOCK_OF(plii_link_colors, storage, storage_size)},
    {0},
};

static int link_colors_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                       size_t* sizes) {
    (void)state;
    sizes[0] = link_colors_work_size(body, change->node_count, change->link_count);
    sizes[1] = link_colors_max_bytes(body, change->link_count);
    return 2;
}

static void link_colors_topology_commit(pli_body* body, void* state, const plii_topology_change* change,
                                        void** blocks) {
    plii_link_colors* colors = state;
    plii_release(body->context, colors->storage, colors->storage_size);
    const size_t most_bytes = link_colors_max_bytes(body, change->link_count);
    link_colors_block spare = {blocks[2], most_bytes};
    (void)link_colors_make(body, blocks[1], &spare, colors);
    plii_release(body->context, blocks[1], link_colors_work_size(body, change->node_count, change->link_count));
    plii_release(body->context, spare.memory, spare.size);
}

const plii_feature_class plii_link_colors_class = {
    .name = "link colors",
    .state_size = sizeof(plii_link_colors),
    .arrays = link_colors_arrays,
    .enable = link_colors_enable,
    .topology_blocks = link_colors_topology_blocks,
    .topology_commit = link_colors_topology_commit,
};
