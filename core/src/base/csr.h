#ifndef PLII_CSR_H
#define PLII_CSR_H

/* Lists of items by key, compressed: those of key k are items[begin[k]] to items[begin[k + 1] - 1]. To make them, count
   the items of each key in `begin` [key_count + 1], which starts as zeros, sum up, and put the items in place from the
   last one to the first; then each list is in the order of items:

       ++begin[key];
       plii_csr_sum(key_count, begin);
       items[--begin[key]] = item; */

/* Turns counts into where each list ends; returns how many items there are. */
static inline int plii_csr_sum(int key_count, int* begin) {
    int sum = 0;
    for (int k = 0; k < key_count; ++k) {
        sum += begin[k];
        begin[k] = sum;
    }
    begin[key_count] = sum;
    return sum;
}

/* Indices of keys [item_count] by key. `begin` need not be zero. */
static inline void plii_csr_sort(int key_count, int item_count, const int* keys, int* begin, int* items) {
    for (int k = 0; k <= key_count; ++k) {
        begin[k] = 0;
    }
    for (int i = 0; i < item_count; ++i) {
        ++begin[keys[i]];
    }
    (void)plii_csr_sum(key_count, begin);
    for (int i = item_count - 1; i >= 0; --i) {
        items[--begin[keys[i]]] = i;
    }
}

#endif
