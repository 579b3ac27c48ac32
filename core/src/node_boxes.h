#ifndef PLII_NODE_BOXES_H
#define PLII_NODE_BOXES_H

/* Boxes of nodes that are kept from step to step as in Bullet's tree of nodes, for comparisons: rigid bodies are met by
   the nodes whose boxes they touch. */

#include "body_impl.h"

extern const plii_feature_class plii_node_boxes_class;

/* Of all nodes, brought up to date in the present step; NULL when they are not kept. */
const pli_bounds* plii_node_boxes(const pli_body* body);
/* Those of soft contacts, likewise. */
const pli_bounds* plii_soft_contacts_node_boxes(const pli_body* body);
/* Takes over others; false when they are not kept. */
bool plii_node_boxes_set(pli_body* body, const pli_bounds* boxes);

#endif
