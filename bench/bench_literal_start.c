/* Fall of a free cloth under the implicit solver with the literal start, beside the formula and beside the free-flight
   start. The cloth is that of Kang, "Efficient Methods for Cloth Animation and Collision Handling": springs to the four
   neighbours, both diagonals and the nodes two further, one time step per frame; it stands upright, so that springs lie
   along gravity. */

#include <pliant/pliant.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { NODES = 35, STEPS = 30 };

static void check(pli_status status) {
    if (status == PLI_OK) { return; }
    fprintf(stderr, "%s\n", pli_status_string(status));
    exit(1);
}

static int node_at(int column, int row) {
    return row * NODES + column;
}

static void link_if_inside(pli_mesh* mesh, int column, int row, int right, int up) {
    const int to_column = column + right, to_row = row + up;
    if (to_column < 0 || to_column >= NODES || to_row >= NODES) { return; }
    check(pli_mesh_append_link(mesh, node_at(column, row), node_at(to_column, to_row), 0, NULL));
}

static pli_mesh* make_cloth(pli_context* context) {
    pli_mesh* mesh = NULL;
    check(pli_mesh_create(context, &mesh));
    for (int i = 0; i < NODES * NODES; ++i) {
        const pli_vec3 x = pli_vec3_make(0.03f * (float)(i % NODES), 0.03f * (float)(i / NODES), 0);
        check(pli_mesh_append_node(mesh, x, 1.0f, NULL));
    }
    for (int i = 0; i < NODES * NODES; ++i) {
        const int column = i % NODES, row = i / NODES;
        for (int reach = 1; reach <= 2; ++reach) {
            link_if_inside(mesh, column, row, reach, 0);
            link_if_inside(mesh, column, row, 0, reach);
        }
        link_if_inside(mesh, column, row, 1, 1);
        link_if_inside(mesh, column, row, -1, 1);
    }
    return mesh;
}

typedef struct fall {
    double first_step; /* change of velocity of the middle node, as a share of g h */
    double distance;   /* of the centre of mass after STEPS steps, as a share of free fall */
} fall;

static double mean_height(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    double sum = 0.0;
    for (int i = 0; i < view.node_count; ++i) {
        sum += (double)view.positions[i].y;
    }
    return sum / view.node_count;
}

static fall run(pli_implicit_start start, float stiffness, int sweeps) {
    const float dt = 1.0f / 60.0f;
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_body* body = NULL;
    check(pli_context_create(NULL, &context));
    check(pli_world_create(context, NULL, &world));
    pli_mesh* mesh = make_cloth(context);
    check(pli_body_create(world, mesh, NULL, &body));
    pli_mesh_destroy(mesh);
    pli_implicit_def def = pli_implicit_def_default();
    def.stiffness = stiffness;
    def.sweeps = sweeps;
    def.start = start;
    check(pli_body_enable_implicit(body, &def));
    const double before = mean_height(body);
    fall result = {0};
    for (int i = 0; i < STEPS; ++i) {
        check(pli_world_step(world, dt));
        if (i == 0) {
            const float v = pli_body_get_view(body).velocities[node_at(NODES / 2, NODES / 2)].y;
            result.first_step = -(double)v / (10.0 * (double)dt);
        }
    }
    const double way = 10.0 * (double)dt * (double)dt * 0.5 * STEPS * (STEPS + 1);
    result.distance = (before - mean_height(body)) / way;
    pli_world_destroy(world);
    pli_context_destroy(context);
    return result;
}

int main(void) {
    printf("%d x %d nodes of 1 kg, h = 1/60 s; change of velocity in the first step over g h, middle of the cloth;\n"
           "distance fallen in %d steps over that of free fall\n\n",
           NODES, NODES, STEPS);
    printf("| k, N/m | sweeps s | literal | 1 - (1 - m/W)^(s+1) | (s+1) m/W | free flight | literal, distance | free "
           "flight, distance |\n|---|---|---|---|---|---|---|---|\n");
    static const int sweeps[] = {1, 3, 5, 15};
    for (double stiffness = 1e2; stiffness < 2e6; stiffness *= 100.0) {
        for (int i = 0; i < 4; ++i) {
            /* Along gravity: two springs up and down of either reach, four diagonals at half. */
            const double h = (double)(1.0f / 60.0f), diagonal = 1.0 + h * h * stiffness * (4.0 + 2.0);
            const fall literal = run(PLI_IMPLICIT_START_AT_REST, (float)stiffness, sweeps[i]);
            const fall flight = run(PLI_IMPLICIT_START_IN_FREE_FLIGHT, (float)stiffness, sweeps[i]);
            printf("| %.0e | %d | %.5f | %.5f | %.5f | %.6f | %.5f | %.6f |\n", stiffness, sweeps[i],
                   literal.first_step, 1.0 - pow(1.0 - 1.0 / diagonal, sweeps[i] + 1), (sweeps[i] + 1) / diagonal,
                   flight.first_step, literal.distance, flight.distance);
        }
    }
    return 0;
}
