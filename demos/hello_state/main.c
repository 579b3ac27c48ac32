// A crate on a sheet and a player who pushes it, whose input comes eight frames late; then the world as a file.
#include <pliant/pliant.h>
#include <stdio.h>
#include <stdlib.h>

static pli_context* context;

static void check(pli_status status) {
    if (status == PLI_OK) { return; }
    fprintf(stderr, "%s\n", pli_last_error(context));
    exit(1);
}

static pli_world* world;
static pli_rigid* crate;

// A solid cube, kg and m. Soft bodies push it; pli_rigid_integrate moves it.
static pli_rigid* make_crate(float mass, float side, pli_vec3 place) {
    pli_shape* box;
    pli_rigid* made;
    check(pli_shape_create_box(context, pli_vec3_make(0.5f * side, 0.5f * side, 0.5f * side), &box));
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.shapes = &box;
    def.shape_count = 1;
    def.state.pose.origin = place;
    def.state.inverse_mass = 1 / mass;
    const float inverse = 6 / (mass * side * side); // of a ball 2.5 / (mass * radius^2); 0: it does not turn
    def.state.inverse_inertia_world = (pli_mat3){{{inverse, 0, 0}, {0, inverse, 0}, {0, 0, inverse}}};
    check(pli_rigid_create(world, &def, &made));
    pli_shape_release(box);
    return made;
}

static void make_world(void) {
    check(pli_world_create(context, NULL, &world));
    pli_mesh* mesh;
    pli_body* sheet;
    pli_patch_def patch = pli_patch_def_default();
    patch.columns = patch.rows = 21;
    patch.pins = PLI_PATCH_PIN_CORNERS;
    check(pli_mesh_create_patch(context, &patch, &mesh));
    check(pli_mesh_set_total_mass(mesh, 0.3f));
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 10;
    check(pli_body_create(world, mesh, &def, &sheet));
    pli_mesh_destroy(mesh);
    check(pli_body_enable_colored_links(sheet));
    check(pli_body_enable_rigid_contacts(sheet, NULL));
    crate = make_crate(0.5f, 0.3f, pli_vec3_make(0, 0.2f, 0));
}

// `input`: m/s, that the player adds to the speed of the crate along x.
static void step_game(float input) {
    const float dt = 1.0f / 60.0f;
    pli_rigid_state state = pli_rigid_get_state(crate);
    state.linear_velocity.x += input;
    check(pli_rigid_set_state(crate, &state));
    check(pli_world_step(world, dt));
    check(pli_rigid_integrate(crate, pli_world_get_gravity(world), dt));
}

enum { DEPTH = 8 };

typedef struct frame {
    void* before; // a snapshot
    size_t capacity, size;
    float input;
} frame;

static frame frames[DEPTH];
static int now;

static void step_frame(float guess) {
    frame* next = &frames[now % DEPTH];
    next->input = guess;
    const size_t size = pli_world_snapshot_size(world); // grows with contacts
    if (size > next->capacity) {
        free(next->before);
        next->capacity = 2 * size;
        next->before = malloc(next->capacity);
    }
    check(pli_world_save(world, next->before, next->capacity, &next->size));
    step_game(guess);
    ++now;
}

// `input` is that of a frame at most DEPTH frames ago: all since then are stepped again when it was guessed wrong.
static void correct(int number, float input) {
    const frame* wrong = &frames[number % DEPTH];
    const int end = now;
    if (wrong->input == input) { return; }
    check(pli_world_restore(world, wrong->before, wrong->size));
    now = number;
    while (now < end) {
        step_frame(now == number ? input : frames[now % DEPTH].input);
    }
}

static pli_world* copy_by_file(void) {
    const size_t size = pli_world_file_size(world);
    void* bytes = malloc(size);
    check(pli_world_file_write(world, NULL, bytes, size, NULL));
    // ... in another process:
    pli_world* copy;
    check(pli_world_file_create(context, NULL, bytes, size, &copy));
    free(bytes);
    return copy; // bodies and rigid bodies keep their order (pli_world_get_body), anchors and joints their ids
}

static uint64_t hash_of(const pli_world* of) {
    return pli_body_state_hash(pli_world_get_body(of, 0));
}

static float input_of(int number) {
    return number % 60 < 30 ? 0.05f : -0.05f;
}

int main(void) {
    const int count = 180;
    check(pli_context_create(NULL, &context));
    make_world();
    for (int i = 0; i < count; ++i) {
        step_game(input_of(i));
    }
    const uint64_t hash = hash_of(world);
    pli_world_destroy(world);

    make_world();
    for (int i = 0; i < count + DEPTH; ++i) {
        if (i >= DEPTH) { correct(i - DEPTH, input_of(i - DEPTH)); }
        if (i < count) { step_frame(i >= DEPTH ? input_of(i - DEPTH) : 0); } // guess: as the last one known
    }
    printf("after %d frames with late input: %s, the crate is at y = %.2f m\n", count,
           hash_of(world) == hash ? "equal" : "different", (double)pli_rigid_get_state(crate).pose.origin.y);

    pli_world* copy = copy_by_file();
    check(pli_world_step(world, 1.0f / 60.0f));
    check(pli_world_step(copy, 1.0f / 60.0f));
    printf("a step of the world from the file: %s\n", hash_of(copy) == hash_of(world) ? "equal" : "different");

    pli_world_destroy(copy);
    pli_world_destroy(world);
    for (int i = 0; i < DEPTH; ++i) {
        free(frames[i].before);
    }
    check(pli_context_destroy(context));
    return 0;
}
