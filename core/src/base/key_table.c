/* Growing a table of keys, and adding to it. */

#include "base/key_table.h"

bool plii_key_table_reserve(plii_key_table* table, int count) {
    if (count <= table->capacity / 2) { return true; }
    if (count > INT32_MAX / 4) { return false; }
    plii_key_table grown = {.context = table->context, .capacity = 16};
    while (grown.capacity / 2 < count) {
        grown.capacity *= 2;
    }
    if (!PLII_ALLOCATE(table->context, &grown.slots, grown.capacity)) { return false; }
    for (int i = 0; i < table->capacity; ++i) {
        const plii_key_slot slot = table->slots[i];
        if (slot.key1 != 0) { *plii_key_table_probe(&grown, slot.key1 - 1) = slot; }
    }
    grown.count = table->count;
    plii_key_table_free(table);
    *table = grown;
    return true;
}

int plii_key_table_add(plii_key_table* table, uint64_t key, int index) {
    if (!plii_key_table_reserve(table, table->count + 1)) { return PLI_NULL_INDEX; }
    plii_key_slot* slot = plii_key_table_probe(table, key);
    if (slot->key1 == 0) {
        *slot = (plii_key_slot){key + 1, index};
        table->count += 1;
    }
    return slot->index;
}

void plii_key_table_clear(plii_key_table* table) {
    if (table->count > 0) { memset(table->slots, 0, plii_key_table_bytes(table)); }
    table->count = 0;
}
void plii_key_table_free(plii_key_table* table) {
    plii_release(table->context, table->slots, plii_key_table_bytes(table));
    *table = (plii_key_table){.context = table->context};
}
