/* Quads of links, greedily: all that have six links, then five, four and three, each time in the order of nodes. So a
   triangle mesh falls into pairs of triangles. Linear time: a node shows at most so many of its links. */

#include "solver/coloring/link_quads.h"

enum {
    LINK_QUADS_SHOWN = 24, /* links of a node */
    LINK_QUADS_TRIES = 3,  /* links of a node per pass that may fail to find a quad */
    LINK_QUADS_MOST = 6,   /* links of a quad */
    LINK_QUADS_LEAST = 3,
    LINK_QUADS_ORDERS = 24, /* of four nodes */
    LINK_QUADS_PATTERNS = 1 << PLII_LINK_PAIRS
};

typedef struct link_quads_search {
    const pli_body* body;
    plii_link_quads* quads;
    int a, b;                             /* nodes of the first link */
    int candidates[2 * LINK_QUADS_SHOWN]; /* nodes linked with those */
    int candidate_count;
    uint8_t orders[LINK_QUADS_ORDERS][4];       /* node of the search for each node of the quad */
    uint8_t best_orders[LINK_QUADS_PATTERNS];   /* by the pairs of the search that have links */
    uint8_t ordered_pairs[LINK_QUADS_PATTERNS]; /* what the pairs become by it */
} link_quads_search;

/* Of two different nodes; as plii_link_pair_nodes. */
static uint8_t link_quads_pair(int a, int b) {
    static const uint8_t pairs[4][4] = {{0, 0, 2, 4}, {0, 0, 5, 3}, {2, 5, 0, 1}, {4, 3, 1, 0}};
    return pairs[a][b];
}

/* Quads get the nodes in the order that uses the first pairs, so that quads of one kind have the same pairs. */
static void link_quads_make_orders(link_quads_search* search) {
    int count = 0;
    for (int code = 0; code < 256; ++code) {
        const uint8_t order[4] = {(uint8_t)(code & 3), (uint8_t)(code >> 2 & 3), (uint8_t)(code >> 4 & 3),
                                  (uint8_t)(code >> 6)};
        if ((1 << order[0] | 1 << order[1] | 1 << order[2] | 1 << order[3]) != 15) { continue; }
        uint8_t from[PLII_LINK_PAIRS];
        for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
            from[k] = link_quads_pair(order[plii_link_pair_nodes[k][0]], order[plii_link_pair_nodes[k][1]]);
        }
        for (int pattern = 0; pattern < LINK_QUADS_PATTERNS; ++pattern) {
            int pairs = 0;
            for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
                pairs |= (pattern >> from[k] & 1) << k;
            }
            if (count == 0 || pairs < search->ordered_pairs[pattern]) {
                search->best_orders[pattern] = (uint8_t)count;
                search->ordered_pairs[pattern] = (uint8_t)pairs;
            }
        }
        memcpy(search->orders[count++], order, sizeof order);
    }
}

/* How many links a node shows, from the first one that is not used. */
static int link_quads_shown(const link_quads_search* search, int node, const plii_half_link** first) {
    const plii_link_quads* quads = search->quads;
    const int end = quads->begin[node + 1];
    int begin = quads->open[node];
    while (begin < end && quads->is_used[quads->halves[begin].link] != 0) {
        ++begin;
    }
    quads->open[node] = begin;
    *first = &quads->halves[begin];
    return end - begin < LINK_QUADS_SHOWN ? end - begin : LINK_QUADS_SHOWN;
}

static void link_quads_mark(link_quads_search* search, int node, uint8_t mark) {
    plii_link_quads* quads = search->quads;
    const plii_half_link* first = NULL;
    const int shown = link_quads_shown(search, node, &first);
    for (PLII_EACH(const plii_half_link, half, first, shown)) {
        const int other = half->neighbour;
        if (other == search->a || other == search->b || quads->is_used[half->link] != 0) { continue; }
        if (quads->marks[other] == 0) { search->candidates[search->candidate_count++] = other; }
        quads->marks[other] |= mark;
    }
}

/* Links that a node has with a and b. */
static int link_quads_common(const link_quads_search* search, int node) {
    const int mark = search->quads->marks[node];
    return (mark & 1) + (mark >> 1);
}

/* The fourth node, given the third one; PLI_NULL_INDEX when no quad of `least` links has both. */
static int link_quads_fourth(const link_quads_search* search, int candidate, int least) {
    const plii_link_quads* quads = search->quads;
    const int third = search->candidates[candidate];
    const int count = 1 + link_quads_common(search, third);
    const plii_half_link* first = NULL;
    const int shown = link_quads_shown(search, third, &first);
    for (PLII_EACH(const plii_half_link, half, first, shown)) {
        const int other = half->neighbour;
        if (other == search->a || other == search->b || quads->is_used[half->link] != 0) { continue; }
        if (count + link_quads_common(search, other) + 1 >= least) { return other; }
    }
    for (int i = candidate + 1; i < search->candidate_count; ++i) {
        if (count + link_quads_common(search, search->candidates[i]) >= least) { return search->candidates[i]; }
    }
    return PLI_NULL_INDEX;
}

/* The other two nodes of a quad with at least so many links; of a triangle there is no fourth one. */
static bool link_quads_others(link_quads_search* search, int least, int others[2]) {
    plii_link_quads* quads = search->quads;
    search->candidate_count = 0;
    link_quads_mark(search, search->a, 1);
    link_quads_mark(search, search->b, 2);
    others[0] = others[1] = PLI_NULL_INDEX;
    for (int i = 0; i < search->candidate_count && others[1] == PLI_NULL_INDEX; ++i) {
        const int common = link_quads_common(search, search->candidates[i]);
        if (least > 4 && common < 2) { continue; } /* one of the two has both links then, and comes as the third */
        others[1] = link_quads_fourth(search, i, least);
        if (others[1] != PLI_NULL_INDEX || 1 + common >= least) { others[0] = search->candidates[i]; }
    }
    for (int i = 0; i < search->candidate_count; ++i) {
        quads->marks[search->candidates[i]] = 0;
    }
    return others[0] != PLI_NULL_INDEX;
}

static int link_quads_find_link(const link_quads_search* search, int a, int b) {
    if (a == PLI_NULL_INDEX || b == PLI_NULL_INDEX) { return PLI_NULL_INDEX; }
    const int nodes[2] = {a, b};
    for (int k = 0; k < 2; ++k) {
        const plii_half_link* first = NULL;
        const int shown = link_quads_shown(search, nodes[k], &first);
        for (PLII_EACH(const plii_half_link, half, first, shown)) {
            if (half->neighbour == nodes[1 - k] && search->quads->is_used[half->link] == 0) { return half->link; }
        }
    }
    return PLI_NULL_INDEX;
}

static void link_quads_add(link_quads_search* search, const int others[2]) {
    plii_link_quads* quads = search->quads;
    const int nodes[4] = {search->a, search->b, others[0], others[1]};
    int links[PLII_LINK_PAIRS], pattern = 0;
    for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
        links[k] = link_quads_find_link(search, nodes[plii_link_pair_nodes[k][0]], nodes[plii_link_pair_nodes[k][1]]);
        if (links[k] != PLI_NULL_INDEX) { pattern |= 1 << k; }
    }
    const uint8_t* order = search->orders[search->best_orders[pattern]];
    plii_link_quad* quad = &quads->quads[quads->quad_count++];
    quad->first_link = quads->in_quads;
    quad->pairs = search->ordered_pairs[pattern];
    for (int k = 0; k < 4; ++k) {
        quad->nodes[k] = nodes[order[k]] != PLI_NULL_INDEX ? nodes[order[k]] : nodes[order[0]];
    }
    for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
        if ((quad->pairs >> k & 1) == 0) { continue; }
        const int link = links[link_quads_pair(order[plii_link_pair_nodes[k][0]], order[plii_link_pair_nodes[k][1]])];
        quads->links[quads->in_quads++] = link;
        quads->is_used[link] = 1;
    }
}

static void link_quads_pass(link_quads_search* search, int least) {
    const plii_link_quads* quads = search->quads;
    for (int node = 0; node < search->body->node_count; ++node) {
        int tries = 0;
        for (int i = quads->open[node]; i < quads->begin[node + 1] && tries < LINK_QUADS_TRIES; ++i) {
            const plii_half_link half = quads->halves[i];
            if (half.neighbour < node || quads->is_used[half.link] != 0) { continue; }
            search->a = node;
            search->b = half.neighbour;
            int others[2];
            if (link_quads_others(search, least, others)) {
                link_quads_add(search, others);
            } else {
                ++tries;
            }
        }
    }
}

/* After those of quads. */
static void link_quads_list_singles(const pli_body* body, plii_link_quads* quads) {
    for (int node = 0; node < body->node_count; ++node) {
        for (int i = quads->begin[node]; i < quads->begin[node + 1]; ++i) {
            const plii_half_link half = quads->halves[i];
            if (half.neighbour < node || quads->is_used[half.link] != 0) { continue; }
            quads->links[quads->in_quads + quads->single_count++] = half.link;
        }
    }
}

void plii_link_quads_find(const pli_body* body, bool is_wanted, plii_link_quads* quads) {
    quads->quad_count = quads->in_quads = quads->single_count = 0;
    plii_csr_half_links(body->node_count, body->link_count, body->links, sizeof *body->links, quads->begin,
                        quads->halves);
    memcpy(quads->open, quads->begin, (size_t)body->node_count * sizeof *quads->open);
    if (is_wanted) {
        link_quads_search search = {.body = body, .quads = quads};
        link_quads_make_orders(&search);
        for (int least = LINK_QUADS_MOST; least >= LINK_QUADS_LEAST; --least) {
            link_quads_pass(&search, least);
        }
    }
    link_quads_list_singles(body, quads);
}
