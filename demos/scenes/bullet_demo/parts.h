#ifndef SCENE_PARTS_H
#define SCENE_PARTS_H

/* What several scenes have in common. */

#include "description/scene_builder.h"

static const float half_pi = 1.5707963f;

/* The slab that all scenes stand on: its top is at y = -10.5. */
void part_ground(scene_builder* builder);
/* Triangles in waves, 5 m up and down around y = -12. */
void part_wavy_ground(scene_builder* builder);
/* Bodies of 10 kg above each other, in turn a compound of a box and a cylinder, a box and a ball. */
void part_falling_stack(scene_builder* builder, int count);
void part_big_ball(scene_builder* builder);
/* A loose plate, rough. Index of the rigid body. */
int part_plate(scene_builder* builder, float mass, float height);
/* Static steps that rise along x from `first`. */
void part_stair(scene_builder* builder, pli_vec3 first, pli_vec3 half_extents, int count);

/* A level square sheet with diagonals, `columns` by `columns` nodes. */
pli_mesh* part_sheet(scene_builder* builder, pli_vec3 center, float half_width, int columns, int pins);
pli_mesh* part_rope(scene_builder* builder, pli_vec3 from, pli_vec3 to, int inner_nodes, int pins);

/* A torus of 50 kg with bending links, clusters and cluster contacts, scaled, turned and moved in this order. `def` may
   be changed before it is added. */
pli_mesh* part_cluster_torus(scene_builder* builder, pli_vec3 position, pli_quat rotation, pli_vec3 scale,
                             scene_soft_def* def);
/* Settings of a body whose clusters collide and whose nodes do not. */
scene_soft_def part_cluster_def(const char* name, int cluster_count, float friction);

void part_set_stiffness(scene_builder* builder, pli_mesh* mesh, float linear_stiffness);
/* Links to the neighbours of neighbours, of a new material. */
void part_add_bending(scene_builder* builder, pli_mesh* mesh, float linear_stiffness);

#endif
