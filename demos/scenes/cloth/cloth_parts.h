#ifndef SCENE_CLOTH_PARTS_H
#define SCENE_CLOTH_PARTS_H

/* What the scenes of cloth that meets itself have in common. Sizes are those of large cloth, a few metres. */

#include "description/scene_builder.h"

/* The floor, its top at y = 0. */
void cloth_part_floor(scene_builder* builder);

/* A grid of nodes with diagonals and soft links to the nodes after next, which keep it from folding too sharply. */
typedef struct cloth_part {
    scene_resolution resolution;
    bool is_tube; /* the last column is linked to the first */
    /* Place of a node, u and v from 0 to 1 along columns and rows; u < 1 in tubes. */
    pli_vec3 (*place)(float u, float v);
    float mass;    /* kg, of the whole */
    float bending; /* stiffness of the soft links over that of the others, (0, 1] */
} cloth_part;

/* Node of column c and row r: r * columns + c. */
pli_mesh* cloth_part_mesh(scene_builder* builder, const cloth_part* part);

/* Settings of such a cloth: stiff links, self-collision of nodes that keep `spacing` (the distance of linked ones). */
scene_soft_def cloth_part_def(const char* name, float spacing);

/* A body that scene_move_rigid moves. Index of the rigid body. */
int cloth_part_kinematic(scene_builder* builder, const char* name, scene_shape shape, pli_vec3 origin);
/* Anchors of a whole column or row. */
void cloth_part_anchor_column(scene_builder* builder, int soft, scene_resolution resolution, int column, int rigid);
void cloth_part_anchor_row(scene_builder* builder, int soft, scene_resolution resolution, int row, int rigid);

#endif
