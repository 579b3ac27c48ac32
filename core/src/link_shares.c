#include "link_shares.h"

static int link_shares_offset(const plii_link_runs* runs, int color) {
    return runs->runs[runs->colors[color].first_run].offset;
}
static int link_shares_widest_offset(const plii_link_runs* runs) {
    int widest = 0;
    for (int c = 0; c < runs->color_count; ++c) {
        widest = link_shares_offset(runs, c) > widest ? link_shares_offset(runs, c) : widest;
    }
    return widest;
}

/* By its place in a colour. */
typedef struct link_shares_group {
    const plii_link_run* run;
    int first_node;
} link_shares_group;

static link_shares_group link_shares_group_at(const plii_link_runs* runs, int color, int group) {
    const plii_link_run_color* own = &runs->colors[color];
    const plii_link_run* run = plii_link_run_at(runs, own, group);
    return (link_shares_group){run, plii_link_run_node(run, group + own->first_group - run->first_group)};
}

/* Groups of a colour whose first node comes before a node; they lie in the order of their first nodes. */
static int link_shares_groups_before(const plii_link_runs* runs, int color, int node) {
    const plii_link_run_color* own = &runs->colors[color];
    int low = 0, high = own[1].first_group - own[0].first_group;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (link_shares_group_at(runs, color, middle).first_node < node) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

// ------------------------------------------------------------------------------------------------------- choosing

/* The last group that begins before a node ends before it too. The end of a row has links of the group before it, so it
   is then on the same side. */
static bool link_shares_parts_links(const plii_link_runs* runs, int color, int node) {
    const int before = link_shares_groups_before(runs, color, node);
    if (before == 0) { return true; }
    const link_shares_group last = link_shares_group_at(runs, color, before - 1);
    const int offset = last.run->offset, way = plii_link_run_way(offset, last.run->step, PLII_LINK_LANES - 1);
    return last.first_node + way + (plii_link_run_has_turns(offset) ? offset : 0) < node;
}
static bool link_shares_may_begin_at(const plii_link_runs* runs, int node) {
    for (int c = 0; c < runs->color_count; ++c) {
        const int offset = link_shares_offset(runs, c), second = plii_link_run_has_turns(offset) ? node : node - offset;
        if (!link_shares_parts_links(runs, c, node) || !link_shares_parts_links(runs, c, second)) { return false; }
    }
    return true;
}

/* The nearest node to one where a share may begin; PLI_NULL_INDEX where there is none within `reach`. */
static int link_shares_node_near(const plii_link_runs* runs, int wanted, int reach) {
    const int middle = wanted / PLII_NODE_SHARES_BLOCK * PLII_NODE_SHARES_BLOCK;
    for (int way = 0; way <= reach; way += PLII_NODE_SHARES_BLOCK) {
        if (link_shares_may_begin_at(runs, middle - way)) { return middle - way; }
        if (link_shares_may_begin_at(runs, middle + way)) { return middle + way; }
    }
    return PLI_NULL_INDEX;
}

static bool link_shares_try(const pli_body* body, const plii_link_runs* runs, int count, plii_node_shares* shares) {
    enum { LEAST_WIDTH = 12, REACH = 4 }; /* of a share, and around where it should begin, in widest offsets */
    const int offset = link_shares_widest_offset(runs);
    if (body->node_count / count / LEAST_WIDTH < offset) { return false; }
    for (int i = 1; i < count; ++i) {
        const int wanted = (int)((int64_t)body->node_count * i / count);
        shares->first[i] = link_shares_node_near(runs, wanted, REACH * offset);
        if (shares->first[i] == PLI_NULL_INDEX) { return false; }
    }
    shares->first[count] = body->node_count;
    shares->count = count;
    shares->half = 0;
    for (int i = 0; i < count; ++i) {
        const int half = plii_planes_half(shares->first[i + 1] - shares->first[i]);
        shares->half = half > shares->half ? half : shares->half;
    }
    return plii_node_shares_fit(body->context, body->node_count, shares);
}

void plii_link_shares_choose(const pli_body* body, const plii_link_runs* runs, plii_node_shares* shares) {
    *shares = (plii_node_shares){0};
    int count = plii_node_shares_room(body->context, body->node_count);
    while (count > 1 && !link_shares_try(body, runs, count, shares)) {
        --count;
    }
    if (count < 2) { shares->count = 0; }
}

// -------------------------------------------------------------------------------------------------------- working

void plii_link_shares_find(const plii_link_colors* colors, plii_team* team, int member, plii_link_shares* shares) {
    const plii_link_runs* runs = &colors->runs;
    const plii_node_shares* nodes = &colors->shares;
    shares->runs = runs;
    shares->team = team;
    shares->member = member;
    shares->member_count = nodes->count;
    shares->steps = shares->met_steps = 0;
    shares->first_node = shares->common_end = nodes->first[member];
    shares->end_node = nodes->first[member + 1];
    if (member > 0) {
        const int blocks = (link_shares_widest_offset(runs) - 1) / PLII_NODE_SHARES_BLOCK + 1;
        shares->common_end += blocks * PLII_NODE_SHARES_BLOCK;
    }
    const bool is_last = member + 1 == nodes->count;
    for (int c = 0; c < runs->color_count; ++c) {
        plii_link_share* share = &shares->colors[c];
        share->begin = link_shares_groups_before(runs, c, shares->first_node);
        share->low_end = link_shares_groups_before(runs, c, shares->common_end);
        share->is_met = member > 0 && link_shares_groups_before(
                                          runs, c, shares->first_node - link_shares_offset(runs, c)) < share->begin;
        share->end = link_shares_groups_before(runs, c, shares->end_node);
        share->high_begin =
            is_last ? share->end : link_shares_groups_before(runs, c, shares->end_node - link_shares_offset(runs, c));
    }
}

/* Others hear of a step only where they wait for it: what a thread writes for another one to read holds up all that it
   writes afterwards. That is after a step with links to nodes of the next member, before one in which the member before
   has such links, and at the end of a sweep. */
void plii_link_shares_sweep(plii_link_shares* shares, plii_link_shares_fn* solve, const void* task) {
    const int color_count = shares->runs->color_count;
    for (int c = 0; c < color_count; ++c) {
        const plii_link_share* share = &shares->colors[c];
        if (share->begin < share->low_end) {
            plii_team_wait(shares->team, shares->member - 1, shares->met_steps);
            solve(task, c, share->begin, share->low_end);
        }
        if (share->high_begin < share->end) {
            plii_team_wait(shares->team, shares->member + 1, shares->steps);
            solve(task, c, share->high_begin, share->end);
        }
        shares->steps += 1;
        if (share->is_met) { shares->met_steps = shares->steps; }
        if (share->high_begin < share->end || c + 1 == color_count || share[1].is_met) {
            plii_team_signal(shares->team, shares->member, shares->steps);
        }
        if (share->low_end < share->high_begin) { solve(task, c, share->low_end, share->high_begin); }
    }
}

void plii_link_shares_pass(plii_link_shares* shares, pli_range_fn* range, int block, void* task) {
    const int common_end = (shares->common_end - shares->first_node) / block;
    const int end = (shares->end_node - shares->first_node + block - 1) / block;
    if (common_end > 0) {
        plii_team_wait(shares->team, shares->member - 1, shares->met_steps);
        range(0, common_end, task);
    }
    plii_team_signal(shares->team, shares->member, ++shares->steps);
    range(common_end, end, task);
}

void plii_link_shares_turn(plii_link_shares* shares, pli_range_fn* range, void* task) {
    range(shares->first_node, shares->end_node, task);
    plii_team_meet(shares->team, shares->member, shares->member_count, ++shares->steps);
}
