#ifndef PLII_LINK_COLOR_SEARCH_H
#define PLII_LINK_COLOR_SEARCH_H

/* Other colours for the quads and single links of a small body, which leave fewer lanes of groups empty. */

#include <stdbool.h>
#include <stdint.h>

/* At most. */
enum { PLII_COLOR_SEARCH_ITEMS = 256, PLII_COLOR_SEARCH_NODES = 1024, PLII_COLOR_SEARCH_TAGS = 8 };

typedef struct plii_color_item {
    int nodes[4];
    uint8_t node_count; /* of a single link 2 */
    uint8_t tag;        /* groups are of one */
    uint8_t color;
} plii_color_item;

typedef struct plii_color_search {
    int node_count, item_count;
    plii_color_item items[PLII_COLOR_SEARCH_ITEMS];
    int item_begin[PLII_COLOR_SEARCH_NODES + 1]; /* [node_count + 1] into those of the items of a node */
    int items_of_nodes[4 * PLII_COLOR_SEARCH_ITEMS];
} plii_color_search;

/* Items of one colour share no node, before and after. There may be one colour more, and some may have lost their last
   item. Takes some 4 us per item. */
void plii_color_search_run(plii_color_search* search);

#endif
