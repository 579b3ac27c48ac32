#pragma once

/* What a feature of a body is. A step runs stages, never features (docs/architecture.md); they are those of btSoftBody,
   so that results can be compared. A feature is one file, or a few of one name, with one class and one enable function.
   Only the reader of files names all (body/all_features.h, file/file_body.c): what is not enabled is not linked. */

#include "math/definition.h"
#include "pliant/rigid.h"

typedef struct plii_step {
    float dt;         /* s, scaled by the body's time scale */
    float inverse_dt; /* 1/s */
} plii_step;

typedef enum plii_stage {
    PLII_STAGE_FORCES, /* add to body->forces */
    PLII_STAGE_UPDATE, /* after integration: what follows from predicted positions */
    /* Over all bodies together, before any body iterates on its own; n = the largest joint_iterations of a body. */
    PLII_STAGE_JOINT_PREPARE,
    PLII_STAGE_JOINT_START, /* after PREPARE of all: impulses of the last step */
    PLII_STAGE_JOINT_SOLVE,
    PLII_STAGE_JOINT_FINISH,
    PLII_STAGE_PREPARE,  /* once before the iterations */
    PLII_STAGE_VELOCITY, /* each velocity iteration */
    PLII_STAGE_POSITION, /* each position iteration */
    PLII_STAGE_COUPLE,   /* the same, after POSITION of all bodies that are solved side by side */
    PLII_STAGE_SETTLE,  /* after the last COUPLE of a step or substep, before velocities are taken from positions; again
                           while a body `is_parting` */
    PLII_STAGE_DRIFT,   /* each drift iteration */
    PLII_STAGE_FINISH,  /* once after the iterations */
    PLII_STAGE_REFRESH, /* what the next step and the user read: normals */
    PLII_STAGE_COUNT
} plii_stage;

/* Order within a stage: Bullet's. Equal orders run in the order of enabling. The number is an enum constant in the
   feature's own file. In the stages that solve

       below 10   what was left from before
       10 to 39   what others demand: anchors, rigid bodies, other soft bodies
       40         links, which every body has
       41 to 49   what comes after links
       from 50    self-collision */
enum { PLII_ORDER_LINKS = 40 };

struct plii_node_constraint;
struct plii_node_spring;
struct plii_contact_report;

typedef void plii_run_fn(pli_body* body, void* state);
typedef void plii_joined_fn(pli_body* body, pli_rigid* rigid, void* user);
typedef void plii_spring_fn(const struct plii_node_spring* spring, void* user);
typedef void plii_contact_visit_fn(pli_body* body, const struct plii_contact_report* report, void* user);

/* A node that a change of topology adds: at a + share * (b - a), or a copy of a (a == b, share 0). `a` and
   `b` may be new nodes themselves, of smaller index. */
typedef struct plii_node_origin {
    int a, b;
    float share; /* [0, 1] */
} plii_node_origin;

/* Where a face of the new topology was before. */
typedef struct plii_face_origin {
    int parent;  /* old face */
    float share; /* (0, 1], of the parent's area at rest */
} plii_face_origin;

/* A body is cut or refined. Old nodes keep their index; links and faces are renumbered. */
typedef struct plii_topology_change {
    int old_node_count, old_link_count, old_face_count;
    int node_count, link_count, face_count;
    const plii_node_origin* node_origins;   /* [node_count - old_node_count] of the nodes from old_node_count on */
    const plii_face_origin* face_origins;   /* [face_count] */
    const int (*old_faces)[3], (*faces)[3]; /* [old_face_count], [face_count] nodes */
    void* const* old_arrays;                /* of the feature that is told, in the order of its table */
    bool takes_rest_shape;                  /* the present shape becomes the rest shape, as in btSoftBody::refine */
} plii_topology_change;

#define PLII_MAX_FEATURE_ARRAYS 24

/* What the length of an array follows. */
typedef enum plii_array_length { PLII_PER_NODE, PLII_PER_LINK, PLII_PER_FACE, PLII_LIST } plii_array_length;

/* What snapshots do with an array, or a part of a state. Each says it: the test of snapshots fails else. */
typedef enum plii_snapshot_share {
    PLII_NOT_SAID,
    PLII_SAVED,
    PLII_LEFT, /* made anew in every step, or follows from topology and rest lengths, which a snapshot has not */
    PLII_FILED /* left, but in files: it follows from how the body was when the feature was enabled */
} plii_snapshot_share;

/* An array of a feature. One that follows the size of the body is allocated, zeroed, when the feature is enabled, and
   again by the new size when a cut changes the body. A list grows by PLII_RESERVE.
   All are counted with the feature and freed after it is disabled, or when it could not be enabled. */
typedef struct plii_feature_array {
    size_t member; /* offset of the pointer */
    size_t element_size;
    plii_array_length length;
    size_t capacity; /* of a list: offset of its capacity in the state */
    size_t stride;   /* of lists in an array of structs: bytes from one to the next, */
    int copies;      /* and how many there are; 0: 1 */
    int times, per;  /* so many elements for so many nodes, links or faces; 0: 1 */
    int more;        /* elements */
    bool is_in_body; /* the pointer is a member of the body, not of the state */
    bool is_kept;    /* when a cut adds nodes, what belongs to old ones stays; of a list, all does */
    bool is_scratch; /* only there in `enable`, `build` and topology_commit, zeroed */
    /* For snapshots (world/snapshot.c). */
    plii_snapshot_share snapshot;
    size_t count; /* of a list: offset of how many elements are in use, an int. Of one that is left it is 0 after a
                     snapshot was restored; of one that is saved 0 here means that all of its capacity is */
    const char* fields;   /* of an element, as plii_state_part has them */
    plii_limits settings; /* likewise, as those of the class */
} plii_feature_array;

#define PLII_MEMBER(type, pointer) .member = offsetof(type, pointer), .element_size = sizeof *((type*)0)->pointer
#define PLII_LIST_OF(type, pointer, capacity_member)                                                                   \
    PLII_MEMBER(type, pointer), .length = PLII_LIST, .capacity = offsetof(type, capacity_member)

/* Those that each step makes anew. */
#define PLII_LEFT_PER_NODE(type, pointer)                                                                              \
    { PLII_MEMBER(type, pointer), PLII_PER_NODE, .snapshot = PLII_LEFT }
#define PLII_LEFT_LIST(type, pointer, capacity_member)                                                                 \
    { PLII_LIST_OF(type, pointer, capacity_member), .snapshot = PLII_LEFT }
/* Of each struct in an array of the state. */
#define PLII_LEFT_LISTS(type, structs, pointer, capacity_member)                                                       \
    {                                                                                                                  \
        PLII_LIST_OF(type, structs[0].pointer, structs[0].capacity_member),                                            \
            .snapshot = PLII_LEFT, .stride = sizeof((type*)0)->structs[0],                                             \
            .copies = sizeof((type*)0)->structs / sizeof((type*)0)->structs[0]                                         \
    }
#define PLII_LEFT_COUNTED(type, pointer, capacity_member, count_member)                                                \
    { PLII_COUNTED_LIST(type, pointer, capacity_member, count_member), .snapshot = PLII_LEFT }

#define PLII_SAVED_AS(letters) .snapshot = PLII_SAVED, .fields = letters
#define PLII_FILED_AS(letters) .snapshot = PLII_FILED, .fields = letters
#define PLII_COUNTED_LIST(type, pointer, capacity_member, count_member)                                                \
    PLII_LIST_OF(type, pointer, capacity_member), .count = offsetof(type, count_member)

/* Slots of a plii_key_table: after a snapshot was restored they are filled anew. */
#define PLII_KEY_TABLE_OF(type, table)                                                                                 \
    PLII_LIST_OF(type, table.slots, table.capacity), .is_kept = true, .snapshot = PLII_LEFT

/* Lists of a plii_bvh. */
#define PLII_BVH_LISTS(type, tree)                                                                                     \
    PLII_LEFT_LIST(type, tree.items, tree.item_capacity), PLII_LEFT_LIST(type, tree.keys, tree.key_capacity),          \
        PLII_LEFT_LIST(type, tree.boxes.groups, tree.boxes.capacity)

#define PLII_PAIR_RECORD_FIELDS "iiOi|12fi3fBii" /* of a plii_pair_record */
/* Lists of a plii_pair_cache, and its table; what snapshots do with the list of this step, and with that before. */
#define PLII_PAIR_CACHE_LISTS(type, cache, of_present, of_before)                                                      \
    {PLII_COUNTED_LIST(type, cache.present.items, cache.present.capacity, cache.present.count), .is_kept = true,       \
     .snapshot = of_present, .fields = PLII_PAIR_RECORD_FIELDS},                                                       \
        {PLII_KEY_TABLE_OF(type, cache.table)}, {                                                                      \
        PLII_COUNTED_LIST(type, cache.before.items, cache.before.capacity, cache.before.count),                        \
            .is_kept = true, .snapshot = of_before, .fields = PLII_PAIR_RECORD_FIELDS                                  \
    }

/* A member of a state that is neither an array of the table nor its capacity or count. */
typedef struct plii_state_part {
    size_t offset, size; /* 0: the end */
    plii_snapshot_share snapshot;
    /* For files, of what they hold (file/file_impl.h): letters for the numbers in a struct, in the order of its
       members, each with how often it comes:
       f float, d double, i int, u unsigned, U uint64_t, h uint16_t, B bool, eN enum from 0 to N; g as f, may be not a
       number; n N node, F H face, L link; N, H, L -1 for none; R rigid body or NULL, S the same, not NULL, P body or
       NULL, Q a body that may be gone, O rigid body, body, shape of a rigid body or NULL, that is compared only, J
       class of a joint; | where a struct with pointers begins or ends, X a pointer that is not kept, * the rest is not
       kept. They are zero in what is read. */
    const char* fields;
} plii_state_part;
#define PLII_STATE_OF(type, member, snapshot, fields)                                                                  \
    { offsetof(type, member), sizeof((type*)0)->member, snapshot, fields }
#define PLII_STATE(type, member, snapshot) PLII_STATE_OF(type, member, snapshot, NULL)
/* Members that follow each other, from the first to the last one. */
#define PLII_STATE_SPAN(type, first, last, snapshot, fields)                                                           \
    { offsetof(type, first), offsetof(type, last) + sizeof((type*)0)->last - offsetof(type, first), snapshot, fields }

struct plii_substep_class;

/* What the features of all bodies are told of a body, or of a rigid body. */
typedef enum plii_notice {
    PLII_BODY_REMOVED, /* it goes away */
    PLII_RIGID_REMOVED,
    PLII_CLUSTERS_REMOVED, /* of the body; the last that something goes away with */
    PLII_TOPOLOGY_CHANGED, /* links and faces of the body are others; told to other bodies only */
    PLII_SHAPES_MOVED,     /* shapes of the rigid body lie in other places in it; for what is kept of them */
    PLII_SHAPES_REPLACED,  /* they are others */
    PLII_NOTICES
} plii_notice;
typedef void plii_notice_fn(pli_body* body, void* state, plii_notice notice, const void* about);

typedef struct plii_feature_class {
    const char* name;
    size_t state_size; /* bytes, zeroed when enabled, freed with the feature */
    /* Features (services) this one reads, NULL-ended; enabled first and shared by count. NULL: none. */
    const struct plii_feature_class* const* needs;
    const plii_feature_array* arrays; /* ended by an element size of 0; NULL: none */
    struct {
        plii_run_fn* run; /* NULL: nothing in this stage */
        int order;
    } stages[PLII_STAGE_COUNT];
    bool acts_on_motion; /* in FORCES, outside of reference mode: last of all, under solvers with substeps first */
    /* How it takes part in substeps, where POSITION is not run (substep.h). NULL: not. */
    const struct plii_substep_class* substepped;

    /* All optional. */
    /* After the needs, with its arrays. Where it lacks memory it is not enabled: nothing may be left behind. */
    void (*enable)(pli_body* body, void* state);
    /* After `enable` and each cut: makes anew what follows from nodes, links and faces, ends what fits no more. */
    void (*build)(pli_body* body, void* state);
    void (*disable)(pli_body* body, void* state);
    /* Passes go on without what they have no memory for, and ask for it again in the next step; plii_allocate notes it,
       and the step tells. Contacts are the first array of the class, counted: of a pair that lacked memory they go. */
    void (*collide_rigid)(pli_body* body, void* state, pli_rigid* rigid);
    /* `other` has the same feature enabled. */
    void (*collide_body)(pli_body* body, void* state, pli_body* other, void* other_state);
    /* Before it: makes what the pair reads of both. NULL: collide_body writes to both bodies, else to `body` alone. */
    void (*prepare_pair)(pli_body* body, void* state, pli_body* other, void* other_state);
    bool acts_with_joints; /* what collides acts in JOINT_* alone: bodies that meet are solved side by side */
    bool looks_at_motion;  /* counts among the sweeping_features of the body */
    bool records_contacts; /* bodies that have it note what contacts push, see contact_report.h */
    bool lets_sleep;       /* and these may sleep */
    /* Writes what rigid bodies demand of nodes in this step, at most `capacity`; returns how many there are. */
    int (*list_constraints)(const pli_body* body, const void* state, int capacity,
                            struct plii_node_constraint* constraints);
    /* Springs of nodes to fixed points, for solvers with `solves_constraints`; after FORCES. */
    void (*visit_springs)(pli_body* body, void* state, plii_spring_fn* visit, void* user);
    /* What its contacts have done in this step (contact_report.h); in REFRESH, of bodies that record it. */
    void (*visit_contacts)(pli_body* body, const void* state, plii_contact_visit_fn* visit, void* user);
    /* What it joins the body to: another body, or a rigid body; the other one of both is NULL. Bodies that are joined
       to the same rigid body are solved by one thread. */
    void (*visit_joined)(const void* state, plii_joined_fn* visit, void* user);
    /* The rigid bodies that its contacts of this step are with, some more than once. */
    void (*visit_met)(const void* state, plii_joined_fn* visit, void* user);
    /* Made by calls that put something into it: worlds without it are the same. Its `enable` may be called again. */
    bool is_made_by_calls;
    const struct plii_solver_class* solver; /* that it brings: steps the body while it is enabled */
    bool meets_sensors;                     /* its collide_rigid is for them too */
    bool collides_last;                     /* its collide_rigid, of which there is one, looks at what others found */
    plii_notice_fn* on[PLII_NOTICES];
    /* What snapshots do with the members of the state (PLII_STATE), ended by a size of 0; needed where there are some
       beside the arrays. Then `on_restored` makes what follows from those that are saved, without memory. */
    const plii_state_part* state_parts;
    /* Numbers of the state that the user gives: checked by the calls that take them, and by the reader of files. */
    plii_limits settings;
    void (*on_restored)(pli_body* body, void* state);
    /* For files, when all bodies are read, before `on_restored`: whether the numbers in it go together. What steps use
       as an index or a count has to be one, but for what its letter has checked. */
    bool (*is_sound)(const pli_body* body, const void* state);
    /* What a file cannot hold, as functions of the user, comes from the state that is given up for this one. */
    void (*keep_callbacks)(void* state, const void* before);
    /* Between steps, after something in the world was added or changed: makes room for what the steps to come will put
       into lists, as far as that follows from what there is now. Without memory the steps ask again. */
    void (*reserve)(pli_body* body, void* state);

    /* A change of topology has two phases, so that it happens wholly or not at all. Features go in the order of
       enabling, needs first. First each makes room in its lists, where it will need more; the body is as before, and
       may stay so. False when out of memory. When memory suffices for all, each gets the body with its new nodes, links
       and faces, and must not fail: new arrays are in place, old ones in `change->old_arrays`. For what keeps lists, as
       of contacts, which end, and all other data per node, link or face. */
    bool (*topology_reserve)(const pli_body* body, void* state, const plii_topology_change* change);
    void (*topology_commit)(pli_body* body, void* state, const plii_topology_change* change);
} plii_feature_class;

/* In a `for`: each array of a class. */
#define PLII_EACH_ARRAY(array, klass)                                                                                  \
    const plii_feature_array* array = (klass)->arrays;                                                                 \
    array != NULL && array->element_size > 0;                                                                          \
    ++array

/* For the tables of a class, which are written where they belong. */
#define PLII_NEEDS(...) ((const plii_feature_class* const[]){__VA_ARGS__, NULL})
#define PLII_ARRAYS(...) ((const plii_feature_array[]){__VA_ARGS__, {0}})
#define PLII_STATE_PARTS(...) ((const plii_state_part[]){__VA_ARGS__, {0}})

typedef struct plii_feature {
    const plii_feature_class* klass;
    void* state;
    int users; /* enabled by the user (1) + features that need it */
    bool by_user;
    bool is_new; /* enabled by the last call that asked for it */
} plii_feature;

typedef struct plii_pipeline_entry {
    plii_run_fn* run;
    void* state;
    const plii_feature_class* klass;
} plii_pipeline_entry;

/* Behind those of the stages: entries of what takes part in substeps, which run it, and of what meets rigid bodies. */
enum { PLII_SUBSTEPPED = PLII_STAGE_COUNT, PLII_COLLIDE_RIGID, PLII_PASS_COUNT };
typedef struct plii_pipeline {
    plii_feature* features; /* in the order of enabling */
    int feature_count, feature_capacity;
    plii_pipeline_entry* entries; /* sorted by stage and order */
    int entry_capacity;
    int begin[PLII_PASS_COUNT + 1];
    uint32_t revision; /* counts features, and clusters, that come and go */
} plii_pipeline;
/* In a `for`: each entry of a stage, or of a pass behind those, by order. */
#define PLII_EACH_ENTRY(entry, body, pass)                                                                             \
    PLII_EACH(const plii_pipeline_entry, entry, &(body)->pipeline.entries[(body)->pipeline.begin[pass]],               \
              (body)->pipeline.begin[(pass) + 1] - (body)->pipeline.begin[pass])
/* In a `for`: each feature of a body. */
#define PLII_EACH_FEATURE(feature, body)                                                                               \
    PLII_EACH(const plii_feature, feature, (body)->pipeline.features, (body)->pipeline.feature_count)
