/* Kempe chains: items of two colours that hang together by their nodes exchange colours, where that does not make a
   sweep longer. What a sweep takes is told by the number of groups and colours. */

#include "link_color_search.h"
#include "link_colors.h"

#include <limits.h>
#include <string.h>

enum {
    COLOR_SEARCH_COLORS = 64,
    COLOR_SEARCH_TRIES = 20,  /* per item */
    COLOR_SEARCH_LONGEST = 8, /* items of a chain */
    COLOR_SEARCH_FEW = 64,    /* items that may get one colour more */
    /* ns, as measured in small spheres and ropes: a group, and waiting for the end of a colour. */
    COLOR_SEARCH_QUADS_TIME = 28,
    COLOR_SEARCH_SINGLES_TIME = 11,
    COLOR_SEARCH_COLOR_TIME = 14
};

typedef struct color_search_count {
    int quads, singles;
} color_search_count;

/* Of two choices the one that takes less time is better, or else the one with larger colours: then the last items
   of the small ones may go. */
typedef struct color_search_cost {
    int time, squares;
} color_search_cost;

typedef struct color_search_state {
    plii_color_search* search;
    int color_count;
    color_search_count counts[COLOR_SEARCH_COLORS][PLII_COLOR_SEARCH_TAGS];
    uint32_t seed;
    int chain[PLII_COLOR_SEARCH_ITEMS];
    bool is_in_chain[PLII_COLOR_SEARCH_ITEMS];
    int least_time;
    uint8_t best[PLII_COLOR_SEARCH_ITEMS]; /* colours that take it */
} color_search_state;

// -------------------------------------------------------------------------------------------------------------- cost

static int color_search_groups(int count) {
    return (count + PLII_LINK_LANES - 1) / PLII_LINK_LANES;
}

static color_search_cost color_search_color_cost(const color_search_state* state, int color) {
    color_search_cost cost = {0, 0};
    int sum = 0;
    for (int tag = 0; tag < PLII_COLOR_SEARCH_TAGS; ++tag) {
        const color_search_count count = state->counts[color][tag];
        const int quad_groups = color_search_groups(count.quads);
        const int room = quad_groups * PLII_LINK_LANES - count.quads; /* single links take it */
        const int singles = count.singles > room ? count.singles - room : 0;
        cost.time += quad_groups * COLOR_SEARCH_QUADS_TIME + color_search_groups(singles) * COLOR_SEARCH_SINGLES_TIME;
        sum += 4 * count.quads + count.singles;
    }
    if (sum > 0) { cost.time += COLOR_SEARCH_COLOR_TIME; }
    cost.squares = sum * sum;
    return cost;
}

static color_search_cost color_search_sum(color_search_cost a, color_search_cost b) {
    return (color_search_cost){a.time + b.time, a.squares + b.squares};
}
static color_search_cost color_search_pair_cost(const color_search_state* state, int color, int other) {
    return color_search_sum(color_search_color_cost(state, color), color_search_color_cost(state, other));
}
static int color_search_time(const color_search_state* state) {
    color_search_cost sum = {0, 0};
    for (int color = 0; color < state->color_count; ++color) {
        sum = color_search_sum(sum, color_search_color_cost(state, color));
    }
    return sum.time;
}
static bool color_search_is_worse(color_search_cost a, color_search_cost b) {
    return a.time > b.time || (a.time == b.time && a.squares < b.squares);
}

// ------------------------------------------------------------------------------------------------------------ chains

static void color_search_count_item(color_search_state* state, const plii_color_item* item, int sign) {
    color_search_count* count = &state->counts[item->color][item->tag];
    if (item->node_count == 2) {
        count->singles += sign;
    } else {
        count->quads += sign;
    }
}

/* Appends the items of a colour that share a node with an item. */
static int color_search_extend(color_search_state* state, int index, int color, int count) {
    const plii_color_search* search = state->search;
    const plii_color_item* item = &search->items[index];
    for (int k = 0; k < item->node_count; ++k) {
        const int *begin = &search->item_begin[item->nodes[k]], *end = begin + 1;
        for (int at = *begin; at < *end; ++at) {
            const int next = search->items_of_nodes[at];
            if (search->items[next].color == color && !state->is_in_chain[next]) {
                state->is_in_chain[next] = true;
                state->chain[count++] = next;
            }
        }
    }
    return count;
}

/* Lists what hangs together with an item; gives 0 where that is too much. */
static int color_search_chain(color_search_state* state, int first, int other) {
    const int color = state->search->items[first].color;
    int count = 1;
    state->chain[0] = first;
    state->is_in_chain[first] = true;
    for (int i = 0; i < count && count <= COLOR_SEARCH_LONGEST; ++i) {
        const int index = state->chain[i];
        count = color_search_extend(state, index, state->search->items[index].color == color ? other : color, count);
    }
    for (int i = 0; i < count; ++i) {
        state->is_in_chain[state->chain[i]] = false;
    }
    return count <= COLOR_SEARCH_LONGEST ? count : 0;
}

static void color_search_exchange(color_search_state* state, int count, int color, int other) {
    for (int i = 0; i < count; ++i) {
        plii_color_item* item = &state->search->items[state->chain[i]];
        color_search_count_item(state, item, -1);
        item->color = (uint8_t)(item->color == color ? other : color);
        color_search_count_item(state, item, 1);
    }
}

// ------------------------------------------------------------------------------------------------------------ search

static int color_search_random(color_search_state* state, int count) {
    state->seed = state->seed * 1664525u + 1013904223u;
    return (int)((uint64_t)state->seed * (uint64_t)count >> 32);
}

static void color_search_try(color_search_state* state) {
    const int first = color_search_random(state, state->search->item_count);
    const int color = state->search->items[first].color;
    int other = color_search_random(state, state->color_count - 1);
    other += other >= color;
    const int count = color_search_chain(state, first, other);
    const color_search_cost before = color_search_pair_cost(state, color, other);
    color_search_exchange(state, count, color, other);
    if (color_search_is_worse(color_search_pair_cost(state, color, other), before)) {
        color_search_exchange(state, count, color, other);
    }
}

static void color_search_count_items(color_search_state* state) {
    memset(state->counts, 0, sizeof state->counts);
    state->color_count = 0;
    for (int i = 0; i < state->search->item_count; ++i) {
        const plii_color_item* item = &state->search->items[i];
        color_search_count_item(state, item, 1);
        if (item->color >= state->color_count) { state->color_count = item->color + 1; }
    }
}

/* Item by item the smallest colour that is free; false where there are too few. */
static bool color_search_spread(plii_color_search* search, int color_count) {
    int sizes[COLOR_SEARCH_COLORS] = {0};
    for (int i = 0; i < search->item_count; ++i) {
        search->items[i].color = COLOR_SEARCH_COLORS;
    }
    for (int i = 0; i < search->item_count; ++i) {
        plii_color_item* item = &search->items[i];
        uint64_t used = 0;
        for (int k = 0; k < item->node_count; ++k) {
            const int *begin = &search->item_begin[item->nodes[k]], *end = begin + 1;
            for (int at = *begin; at < *end; ++at) {
                const int color = search->items[search->items_of_nodes[at]].color;
                if (color < COLOR_SEARCH_COLORS) { used |= (uint64_t)1 << color; }
            }
        }
        for (int color = 0; color < color_count; ++color) {
            const bool is_free = (used >> color & 1) == 0;
            if (is_free && (item->color == COLOR_SEARCH_COLORS || sizes[color] < sizes[item->color])) {
                item->color = (uint8_t)color;
            }
        }
        if (item->color == COLOR_SEARCH_COLORS) { return false; }
        ++sizes[item->color];
    }
    return true;
}

static void color_search_list_items(plii_color_search* search) {
    int* begin = search->item_begin;
    memset(begin, 0, ((size_t)search->node_count + 1) * sizeof *begin);
    for (int i = 0; i < search->item_count; ++i) {
        for (int k = 0; k < search->items[i].node_count; ++k) {
            ++begin[search->items[i].nodes[k]];
        }
    }
    int sum = 0;
    for (int node = 0; node <= search->node_count; ++node) {
        sum += begin[node];
        begin[node] = sum;
    }
    for (int i = search->item_count - 1; i >= 0; --i) {
        for (int k = 0; k < search->items[i].node_count; ++k) {
            search->items_of_nodes[--begin[search->items[i].nodes[k]]] = i;
        }
    }
}

/* Keeps the colours where they are the best so far, but for so many ns. */
static void color_search_keep(color_search_state* state, int tolerance) {
    const int time = color_search_time(state);
    if (time >= state->least_time + tolerance) { return; }
    state->least_time = time;
    for (int i = 0; i < state->search->item_count; ++i) {
        state->best[i] = state->search->items[i].color;
    }
}

static void color_search_improve(color_search_state* state, int tolerance) {
    color_search_count_items(state);
    color_search_keep(state, tolerance);
    for (int i = 0; i < COLOR_SEARCH_TRIES * state->search->item_count; ++i) {
        color_search_try(state);
    }
    color_search_keep(state, 0);
}

void plii_color_search_run(plii_color_search* search) {
    color_search_state state = {.search = search, .least_time = INT_MAX};
    color_search_list_items(search);
    color_search_count_items(&state);
    const int color_count = state.color_count;
    if (color_count < 2) { return; }
    color_search_improve(&state, 0);
    const bool may_spread = search->item_count <= COLOR_SEARCH_FEW && color_count < COLOR_SEARCH_COLORS;
    if (may_spread && color_search_spread(search, color_count + 1)) {
        /* More colours converge better: a box stretches its rope of 20 links a tenth less with three than with two. */
        color_search_improve(&state, state.least_time / 16);
    }
    for (int i = 0; i < search->item_count; ++i) {
        search->items[i].color = state.best[i];
    }
}
