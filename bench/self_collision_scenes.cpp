// Cloth that collides with itself, under XPBD: what the scenes of docs/self_collision.md come to.
//
//   self_collision_scenes fold|ribbon|twist [--columns n] [--rows n] [--seconds s] [--substeps n] [--module none|nodes|
//                         faces|grids|both] [--friction f] [--damping d] [--ratio r] [--solver xpbd|position-based]

#include <pliant/pliant.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

namespace {

struct Options {
    std::string scene = "fold";
    std::string module = "nodes";
    std::string solver = "xpbd";
    int columns = 0, rows = 0, substeps = 10, sweeps = 1, every = 10;
    double seconds = 0.0, friction = 0.1, damping = 0.002, ratio = 0.2, thickness = 0.9, contact_friction = 0.5;
    double bending = 0.0, recovery = 1.0;
};

constexpr float spacing = 0.01f;

// Of the processor, so that other programs disturb less.
double thread_seconds() {
    timespec now = {};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Scene {
public:
    explicit Scene(const Options& options) : options_(options) {
        pli_context_create(nullptr, &context_);
        pli_world_create(context_, nullptr, &world_);
    }
    ~Scene() {
        pli_world_destroy(world_);
        for (pli_shape* shape : shapes_) {
            pli_shape_release(shape);
        }
        pli_context_destroy(context_);
    }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;

    void build() {
        if (options_.scene == "fold") {
            add_floor();
            add_ball(0.2f, pli_vec3_make(0, 0.25f, 0));
            const float half = 0.5f * spacing * static_cast<float>(columns(100) - 1);
            make_sheet(columns(100), rows(100), pli_vec3_make(-half, 0.6f, -half), pli_vec3_make(half, 0.6f, -half),
                       pli_vec3_make(-half, 0.6f, half), 0.3f);
        } else if (options_.scene == "ribbon") {
            add_floor();
            const float height = spacing * static_cast<float>(rows(200) - 1);
            const float half = 0.5f * spacing * static_cast<float>(columns(8) - 1);
            make_sheet(columns(8), rows(200), pli_vec3_make(-half, 0.02f, 0), pli_vec3_make(half, 0.02f, 0),
                       pli_vec3_make(-half, 0.02f + height, 0.01f * height), 0.1f);
        } else {
            pli_world_set_gravity(world_, pli_vec3_make(0, -1, 0));
            const float x = 0.5f * spacing * static_cast<float>(columns(61) - 1);
            const float z = 0.5f * spacing * static_cast<float>(rows(21) - 1);
            make_sheet(columns(61), rows(21), pli_vec3_make(-x, 0, -z), pli_vec3_make(x, 0, -z),
                       pli_vec3_make(-x, 0, z), 0.1f);
        }
        enable();
    }

    void step(int frame) {
        if (options_.scene == "twist") { turn(frame); }
        const double begin = thread_seconds();
        pli_world_step(world_, 1.0f / 60.0f);
        times_.push_back(thread_seconds() - begin);
    }

    double rms_speed() const {
        return std::sqrt(2.0 * static_cast<double>(pli_body_kinetic_energy(body_)) /
                         static_cast<double>(pli_body_total_mass(body_)));
    }
    double max_speed() const {
        const pli_body_view view = pli_body_get_view(body_);
        double largest = 0.0;
        for (int i = 0; i < view.node_count; ++i) {
            const pli_vec4 v = view.velocities[i];
            largest = std::max(largest, static_cast<double>(std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z)));
        }
        return largest;
    }
    int crossings() const {
        int count = 0;
        pli_body_count_crossings(body_, &count);
        return count;
    }

    // Of unlinked nodes, in thicknesses: all pairs are looked at.
    double smallest_distance() const {
        const pli_body_view view = pli_body_get_view(body_);
        const int count = view.node_count;
        std::vector<float> x(static_cast<size_t>(count)), y(x), z(x);
        for (int i = 0; i < count; ++i) {
            const size_t k = static_cast<size_t>(i);
            x[k] = view.positions[i].x, y[k] = view.positions[i].y, z[k] = view.positions[i].z;
        }
        float smallest = 1.0f;
        for (size_t a = 0; a < x.size(); ++a) {
            constexpr size_t chunk = 256;
            for (size_t from = a + 1; from < x.size(); from += chunk) {
                const size_t to = std::min(from + chunk, x.size());
                float least = smallest;
                for (size_t b = from; b < to; ++b) {
                    const float dx = x[b] - x[a], dy = y[b] - y[a], dz = z[b] - z[a];
                    const float squared = dx * dx + dy * dy + dz * dz;
                    least = squared < least ? squared : least;
                }
                if (!(least < smallest)) { continue; }
                for (size_t b = from; b < to; ++b) {
                    const float dx = x[b] - x[a], dy = y[b] - y[a], dz = z[b] - z[a];
                    const float squared = dx * dx + dy * dy + dz * dz;
                    if (squared < smallest && !are_linked(static_cast<int>(a), static_cast<int>(b))) {
                        smallest = squared;
                    }
                }
            }
        }
        return std::sqrt(static_cast<double>(smallest)) / thickness();
    }

    double thickness() const { return options_.thickness * static_cast<double>(spacing); }
    bool is_frozen() const { return pli_body_is_frozen(body_); }
    double median_time() const {
        std::vector<double> sorted = times_;
        std::sort(sorted.begin(), sorted.end());
        return sorted[sorted.size() / 2];
    }
    double largest_time() const { return *std::max_element(times_.begin(), times_.end()); }
    void print_report() const {
        const pli_self_collision_report nodes = pli_body_get_self_collision_report(body_);
        const pli_self_faces_report faces = pli_body_get_self_faces_report(body_);
        std::printf(" | pairs %d contacts %d searches %d limited %d | pairs %d contacts %d shortened %d", nodes.pairs,
                    nodes.contacts, nodes.searches, nodes.limited_nodes, faces.pairs, faces.contacts, faces.shortened);
    }
    void forget_times() { times_.clear(); }
    int node_count() const { return pli_body_get_view(body_).node_count; }

private:
    const Options& options_;
    pli_context* context_ = nullptr;
    pli_world* world_ = nullptr;
    pli_body* body_ = nullptr;
    std::vector<pli_shape*> shapes_;
    std::vector<double> times_;
    std::vector<pli_vec3> rest_;
    int sheet_columns_ = 0, sheet_rows_ = 0;

    int columns(int usual) const { return options_.columns > 0 ? options_.columns : usual; }
    int rows(int usual) const { return options_.rows > 0 ? options_.rows : usual; }

    void add_rigid(pli_shape* shape, pli_vec3 origin) {
        pli_rigid_def def = pli_rigid_def_default();
        def.shape_count = 1;
        def.shapes = &shape;
        def.friction = 1;
        def.state.pose.origin = origin;
        pli_rigid* rigid = nullptr;
        pli_rigid_create(world_, &def, &rigid);
        shapes_.push_back(shape);
    }
    void add_floor() {
        pli_shape* shape = nullptr;
        pli_shape_create_plane(context_, pli_vec3_make(0, 1, 0), 0, &shape);
        add_rigid(shape, pli_vec3_make(0, 0, 0));
    }
    void add_ball(float radius, pli_vec3 origin) {
        pli_shape* shape = nullptr;
        pli_shape_create_sphere(context_, radius, &shape);
        add_rigid(shape, origin);
    }

    bool are_linked(int a, int b) const {
        const int dc = std::abs(a % sheet_columns_ - b % sheet_columns_);
        const int dr = std::abs(a / sheet_columns_ - b / sheet_columns_);
        return dc <= 1 && dr <= 1;
    }

    void make_sheet(int column_count, int row_count, pli_vec3 c00, pli_vec3 c10, pli_vec3 c01, float mass) {
        sheet_columns_ = column_count;
        sheet_rows_ = row_count;
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = c00;
        patch.corner_10 = c10;
        patch.corner_01 = c01;
        patch.corner_11 = pli_vec3_add(c10, pli_vec3_sub(c01, c00));
        patch.columns = column_count;
        patch.rows = row_count;
        patch.diagonals = true;
        pli_mesh* mesh = nullptr;
        pli_mesh_create_patch(context_, &patch, &mesh);
        pli_mesh_set_total_mass(mesh, mass);
        for (int r = 0; options_.scene == "twist" && r < row_count; ++r) {
            pli_mesh_set_node_mass(mesh, r * column_count, 0);
            pli_mesh_set_node_mass(mesh, r * column_count + column_count - 1, 0);
        }
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.5f * spacing;
        def.solver.position_iterations = 4;
        def.solver.velocity_damping = static_cast<float>(options_.damping);
        pli_body_create(world_, mesh, &def, &body_);
        pli_mesh_destroy(mesh);
        const pli_body_view view = pli_body_get_view(body_);
        for (int i = 0; i < view.node_count; ++i) {
            rest_.push_back(pli_vec3_make(view.positions[i].x, view.positions[i].y, view.positions[i].z));
        }
    }

    void enable() {
        pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        if (options_.solver == "xpbd") {
            contacts.friction = static_cast<float>(options_.contact_friction);
            contacts.recovery_speed = static_cast<float>(options_.recovery);
            pli_xpbd_def xpbd = pli_xpbd_def_default();
            xpbd.substeps = options_.substeps;
            xpbd.sweeps = options_.sweeps;
            pli_body_enable_xpbd(body_, &xpbd);
            const pli_xpbd_links_def links = pli_xpbd_links_def_default();
            pli_body_enable_xpbd_links(body_, &links);
            if (options_.bending > 0.0) {
                pli_xpbd_bending_def bending = pli_xpbd_bending_def_default();
                bending.compliance = static_cast<float>(options_.bending);
                pli_body_enable_xpbd_bending(body_, &bending);
            }
        }
        pli_body_enable_rigid_contacts(body_, &contacts);
        if (options_.module == "nodes" || options_.module == "both") {
            pli_self_collision_def def = pli_self_collision_def_default();
            def.thickness = static_cast<float>(thickness());
            def.friction = static_cast<float>(options_.friction);
            def.speed_limit_ratio = static_cast<float>(options_.ratio);
            pli_body_enable_self_collision(body_, &def);
        }
        if (options_.module == "grids") {
            pli_self_grids_def def = pli_self_grids_def_default();
            def.distance = static_cast<float>(thickness());
            pli_body_enable_self_grids(body_, &def);
        }
        if (options_.module == "faces" || options_.module == "both") {
            pli_self_faces_def def = pli_self_faces_def_default();
            def.thickness = static_cast<float>((options_.module == "both" ? 0.5 : 1.0) * thickness());
            def.friction = static_cast<float>(options_.friction);
            pli_body_enable_self_faces(body_, &def);
        }
    }

    // Both ends turn by a full turn against each other's in 8 s, and come nearer.
    void turn(int frame) {
        const float share = std::min(1.0f, static_cast<float>(frame + 1) / 480.0f);
        for (int end = 0; end < 2; ++end) {
            const float angle = (end == 0 ? 1.0f : -1.0f) * 6.2831853f * share;
            for (int r = 0; r < sheet_rows_; ++r) {
                const int node = r * sheet_columns_ + end * (sheet_columns_ - 1);
                const pli_vec3 x = rest_[static_cast<size_t>(node)];
                const pli_vec3 at =
                    pli_vec3_make(x.x * (1.0f - 0.3f * share), -x.z * std::sin(angle), x.z * std::cos(angle));
                pli_body_set_node_position(body_, node, at);
            }
        }
    }
};

bool read_options(int argc, char** argv, Options* options) {
    if (argc < 2) { return false; }
    options->scene = argv[1];
    for (int i = 2; i + 1 < argc; i += 2) {
        const std::string name = argv[i];
        const char* value = argv[i + 1];
        if (name == "--columns") {
            options->columns = std::atoi(value);
        } else if (name == "--rows") {
            options->rows = std::atoi(value);
        } else if (name == "--substeps") {
            options->substeps = std::atoi(value);
        } else if (name == "--sweeps") {
            options->sweeps = std::atoi(value);
        } else if (name == "--every") {
            options->every = std::atoi(value);
        } else if (name == "--seconds") {
            options->seconds = std::atof(value);
        } else if (name == "--module") {
            options->module = value;
        } else if (name == "--solver") {
            options->solver = value;
        } else if (name == "--friction") {
            options->friction = std::atof(value);
        } else if (name == "--contact-friction") {
            options->contact_friction = std::atof(value);
        } else if (name == "--recovery") {
            options->recovery = std::atof(value);
        } else if (name == "--damping") {
            options->damping = std::atof(value);
        } else if (name == "--ratio") {
            options->ratio = std::atof(value);
        } else if (name == "--bending") {
            options->bending = std::atof(value);
        } else if (name == "--thickness") {
            options->thickness = std::atof(value);
        } else {
            return false;
        }
    }
    return options->scene == "fold" || options->scene == "ribbon" || options->scene == "twist";
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    if (!read_options(argc, argv, &options)) {
        std::fprintf(stderr, "usage: %s fold|ribbon|twist [--option value]...\n", argv[0]);
        return 1;
    }
    Scene scene(options);
    scene.build();
    const double seconds = options.seconds > 0.0 ? options.seconds : options.scene == "twist" ? 10.0 : 20.0;
    const int frames = static_cast<int>(std::lround(60.0 * seconds));
    double smallest = 1e30, in_second = 1e30;
    int worst = 0, worst_in_second = 0;
    std::printf("%s, %d nodes, module %s, thickness %.4g m\n", options.scene.c_str(), scene.node_count(),
                options.module.c_str(), scene.thickness());
    for (int frame = 0; frame < frames; ++frame) {
        scene.step(frame);
        if (frame % options.every == 0) {
            if (frame >= 60) {
                const double now = scene.smallest_distance();
                smallest = std::min(smallest, now);
                in_second = std::min(in_second, now);
            }
            const int crossings = scene.crossings();
            worst = std::max(worst, crossings);
            worst_in_second = std::max(worst_in_second, crossings);
        }
        if (frame % 60 == 59) {
            std::printf("%5.1f s: ", (frame + 1) / 60.0);
            if (frame >= 60) { std::printf("smallest distance %.3f, ", in_second); }
            std::printf("crossings %d, speed rms %.5f max %.5f m/s, step median %.3f largest %.3f ms", worst_in_second,
                        scene.rms_speed(), scene.max_speed(), 1e3 * scene.median_time(), 1e3 * scene.largest_time());
            scene.print_report();
            std::printf("\n");
            std::fflush(stdout);
            scene.forget_times();
            in_second = 1e30;
            worst_in_second = 0;
        }
    }
    std::printf("result: smallest distance %.3f thicknesses, crossings %d, speed rms %.5f max %.5f m/s%s\n", smallest,
                worst, scene.rms_speed(), scene.max_speed(), scene.is_frozen() ? ", FROZEN" : "");
    return 0;
}
