#include "random_scene.hpp"

#include "random_shapes.hpp"

#include "engines/components.h"

#include <pliant/bullet_reference.h>
#include <pliant/pliant.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace random_scene {

namespace {

using demos::MeshPointer;

void check(pli_context* context, pli_status status) {
    if (status != PLI_OK) { throw demos::Error(pli_last_error(context)); }
}

// ------------------------------------------------------------------------------------------------------ meshes

MeshPointer make_patch(pli_context* context, const Dice& dice) {
    pli_patch_def def = pli_patch_def_default();
    const float x = dice.uniform("patch width", 0.5f, 2.0f), z = dice.uniform("patch depth", 0.5f, 2.0f);
    def.corner_00 = pli_vec3_make(-x, 0, -z);
    def.corner_10 = pli_vec3_make(x, 0, -z);
    def.corner_01 = pli_vec3_make(-x, 0, z);
    def.corner_11 = pli_vec3_make(x, 0, z);
    def.columns = dice.integer("columns", 2, 7);
    def.rows = dice.integer("rows", 2, 7);
    def.diagonals = dice.has("diagonals", 0.7);
    pli_mesh* mesh = nullptr;
    check(context, dice.has("patch of one direction", 0.3) ? pli_mesh_create_patch_uv(context, &def, nullptr, &mesh)
                                                           : pli_mesh_create_patch(context, &def, &mesh));
    return MeshPointer(mesh);
}

MeshPointer make_hull(pli_context* context, const Dice& dice) {
    std::vector<pli_vec3> points;
    const int count = dice.integer("hull points", 4, 25);
    for (int i = 0; i < count; ++i) {
        points.push_back(dice.vector("hull point" + std::to_string(i), 1.5f));
    }
    pli_mesh* mesh = nullptr;
    check(context, pli_mesh_create_convex_hull(context, count, points.data(), 0.001f, &mesh));
    return MeshPointer(mesh);
}

// A torus of a few triangles, or triangles between points anywhere.
MeshPointer make_triangles(pli_context* context, const Dice& dice) {
    std::vector<pli_vec3> points;
    std::vector<int> triangles;
    if (dice.has("soup", 0.25)) {
        const int count = dice.integer("soup points", 4, 20);
        for (int i = 0; i < count; ++i) {
            points.push_back(dice.vector("soup point" + std::to_string(i), 1.2f));
        }
        for (int i = 0; i < 3 * dice.integer("soup triangles", 2, 15); ++i) {
            triangles.push_back(dice.integer("soup corner" + std::to_string(i), 0, count - 1));
        }
    } else {
        const int around = dice.integer("around", 3, 9), across = dice.integer("across", 3, 6);
        const float large = dice.uniform("large", 0.8f, 1.5f), small = dice.uniform("small", 0.2f, 0.6f);
        for (int i = 0; i < around; ++i) {
            const float a = 6.2831853f * static_cast<float>(i) / static_cast<float>(around);
            for (int k = 0; k < across; ++k) {
                const float b = 6.2831853f * static_cast<float>(k) / static_cast<float>(across);
                const float radius = large + small * std::cos(b);
                points.push_back(pli_vec3_make(radius * std::cos(a), small * std::sin(b), radius * std::sin(a)));
                const int next = (i + 1) % around, beside = (k + 1) % across;
                const int corners[4] = {i * across + k, next * across + k, next * across + beside, i * across + beside};
                for (const int corner : {0, 1, 2, 0, 2, 3}) {
                    triangles.push_back(corners[corner]);
                }
            }
        }
    }
    pli_mesh* mesh = nullptr;
    check(context, pli_mesh_create_from_triangles(context, static_cast<int>(points.size()), points.data(),
                                                  static_cast<int>(triangles.size() / 3), triangles.data(),
                                                  dice.has("shuffled triangles", 0.5), &mesh));
    return MeshPointer(mesh);
}

// A block of cubes of six tetrahedra each.
MeshPointer make_tetras(pli_context* context, const Dice& dice) {
    const int size[3] = {dice.integer("cubes x", 1, 3), dice.integer("cubes y", 1, 2), dice.integer("cubes z", 1, 2)};
    const float edge = dice.uniform("cube", 0.3f, 0.8f);
    std::vector<pli_vec3> points;
    std::vector<int> tetras;
    const auto index = [&](int x, int y, int z) { return (z * (size[1] + 1) + y) * (size[0] + 1) + x; };
    for (int z = 0; z <= size[2]; ++z) {
        for (int y = 0; y <= size[1]; ++y) {
            for (int x = 0; x <= size[0]; ++x) {
                points.push_back(pli_vec3_scale(
                    pli_vec3_make(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)), edge));
            }
        }
    }
    // Six ways from one corner of a cube to the other.
    constexpr int ways[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int z = 0; z < size[2]; ++z) {
        for (int y = 0; y < size[1]; ++y) {
            for (int x = 0; x < size[0]; ++x) {
                for (const auto& way : ways) {
                    int place[3] = {x, y, z};
                    tetras.push_back(index(place[0], place[1], place[2]));
                    for (const int axis : way) {
                        ++place[axis];
                        tetras.push_back(index(place[0], place[1], place[2]));
                    }
                }
            }
        }
    }
    pli_mesh* mesh = nullptr;
    check(context, pli_mesh_create_from_tetras(context, static_cast<int>(points.size()), points.data(),
                                               static_cast<int>(tetras.size() / 4), tetras.data(), &mesh));
    return MeshPointer(mesh);
}

MeshPointer make_plain_mesh(pli_context* context, const Dice& dice, const std::string& kind) {
    pli_mesh* mesh = nullptr;
    if (kind == "rope") {
        check(context, pli_mesh_create_rope(context, dice.vector("rope from", 1.5f), dice.vector("rope to", 1.5f),
                                            dice.integer("rope nodes", 0, 20), 0, &mesh));
    } else if (kind == "ellipsoid") {
        const pli_vec3 radii = pli_vec3_make(dice.uniform("rx", 0.4f, 1.5f), dice.uniform("ry", 0.4f, 1.5f),
                                             dice.uniform("rz", 0.4f, 1.5f));
        check(context, pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 0, 0), radii,
                                                 dice.integer("ellipsoid points", 6, 60), &mesh));
    } else if (kind == "hull") {
        return make_hull(context, dice);
    } else if (kind == "triangles") {
        return make_triangles(context, dice);
    } else if (kind == "tetras") {
        return make_tetras(context, dice);
    } else {
        return make_patch(context, dice);
    }
    return MeshPointer(mesh);
}

const char* random_kind(const Dice& dice) {
    constexpr const char* kinds[] = {"rope", "patch", "patch", "ellipsoid", "hull", "triangles", "tetras"};
    return kinds[dice.integer("mesh", 0, 6)];
}

// Nodes and all that joins them, after those of the other mesh.
void append(pli_context* context, pli_mesh* mesh, const pli_mesh* other, pli_vec3 offset) {
    const int first = pli_mesh_get_view(mesh).node_count;
    const pli_mesh_view view = pli_mesh_get_view(other);
    for (int i = 0; i < view.node_count; ++i) {
        check(context, pli_mesh_append_node(mesh, pli_vec3_add(view.positions[i], offset), 1.0f, nullptr));
    }
    for (int i = 0; i < view.link_count; ++i) {
        const int* n = view.links[i].nodes;
        check(context, pli_mesh_append_link(mesh, first + n[0], first + n[1], 0, nullptr));
    }
    for (int i = 0; i < view.face_count; ++i) {
        const int* n = view.faces[i].nodes;
        check(context, pli_mesh_append_face(mesh, first + n[0], first + n[1], first + n[2], 0, nullptr));
    }
    for (int i = 0; i < view.tetra_count; ++i) {
        const int* n = view.tetras[i].nodes;
        check(context, pli_mesh_append_tetra(mesh, first + n[0], first + n[1], first + n[2], first + n[3], 0, nullptr));
    }
}

void set_masses(pli_context* context, const Dice& dice, pli_mesh* mesh) {
    const int nodes = pli_mesh_get_view(mesh).node_count;
    if (dice.has("total mass", 0.5)) {
        const float mass = std::exp(dice.uniform("mass", -4.0f, 5.0f));
        const bool has_area = pli_mesh_get_view(mesh).face_count > 0 && dice.has("mass from faces", 0.5);
        check(context, has_area ? pli_mesh_set_total_mass_from_faces(mesh, mass) : pli_mesh_set_total_mass(mesh, mass));
    }
    if (dice.has("masses", 0.2)) {
        for (int i = 0; i < nodes; ++i) {
            check(context, pli_mesh_set_node_mass(mesh, i, dice.uniform("mass" + std::to_string(i), 0.1f, 3.0f)));
        }
    }
    if (dice.has("pins", 0.35)) {
        const double share = dice.share("pinned");
        for (int i = 0; i < nodes; ++i) {
            if (dice.share("pin" + std::to_string(i)) < 0.5 * share) {
                check(context, pli_mesh_set_node_mass(mesh, i, 0));
            }
        }
    }
}

void add_links(pli_context* context, const Dice& dice, pli_mesh* mesh) {
    pli_material material = {dice.uniform("stiffness", 0.05f, 1.0f)};
    if (dice.has("soft material", 0.4)) { check(context, pli_mesh_set_material(mesh, 0, &material)); }
    int weak = 0;
    if (dice.has("second material", 0.3)) {
        material.linear_stiffness = dice.uniform("second stiffness", 0.05f, 1.0f);
        check(context, pli_mesh_append_material(mesh, &material, &weak));
    }
    for (int distance = 2; distance <= 3; ++distance) {
        if (dice.has("bending " + std::to_string(distance), 0.3)) {
            check(context, pli_mesh_append_bending_links(mesh, distance, weak, nullptr));
        }
    }
    if (dice.has("shuffled links", 0.3)) { check(context, pli_mesh_shuffle_links(mesh)); }
    if (dice.has("interleaved links", 0.1)) { check(context, pli_mesh_interleave_links(mesh)); }
}

MeshPointer make_mesh(pli_context* context, const Dice& dice) {
    const std::string kind = random_kind(dice);
    dice.note(kind);
    MeshPointer mesh = make_plain_mesh(context, dice, kind);
    for (int i = 1; i < 4; ++i) {
        const Dice part = dice.part("component", i);
        if (!part.has("", 0.1)) { break; }
        const MeshPointer other = make_plain_mesh(context, part, random_kind(part));
        append(context, mesh.get(), other.get(), part.vector("offset", 3.0f));
    }
    add_links(context, dice, mesh.get());
    set_masses(context, dice, mesh.get());
    if (dice.has("size", 0.2)) {
        check(context, pli_mesh_scale(mesh.get(), pli_vec3_make(dice.uniform("size x", 0.3f, 3.0f),
                                                                dice.uniform("size y", 0.3f, 3.0f),
                                                                dice.uniform("size z", 0.3f, 3.0f))));
    }
    if (dice.has("turned", 0.7)) { check(context, pli_mesh_rotate(mesh.get(), dice.turn("turn"))); }
    pli_vec3 place = dice.vector("place", 1.0f);
    place.y += 0.7f;
    if (dice.has("far away", 0.05)) { place = dice.vector("far place", 300.0f); }
    check(context, pli_mesh_translate(mesh.get(), place));
    return mesh;
}

// ------------------------------------------------------------------------------------------------- soft bodies

// btSoftBody hangs in soft contacts of other meshes.
bool is_in_one_piece(const pli_mesh_view& mesh) {
    demos::Components faces(mesh.face_count), nodes(mesh.node_count);
    std::map<std::pair<int, int>, int> face_at_edge;
    for (int i = 0; i < mesh.face_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const auto edge = std::minmax({mesh.faces[i].nodes[k], mesh.faces[i].nodes[(k + 1) % 3]});
            faces.join(i, face_at_edge.try_emplace(edge, i).first->second);
        }
    }
    for (int i = 0; i < mesh.link_count; ++i) {
        nodes.join(mesh.links[i].nodes[0], mesh.links[i].nodes[1]);
    }
    return faces.count() <= 1 && nodes.count() <= 1;
}

void set_solver(const Dice& dice, scene_soft_def& def) {
    pli_solver_settings& solver = def.solver;
    if (dice.has("iterations", 0.5)) { solver.position_iterations = dice.integer("piterations", 0, 6); }
    def.velocity_links = dice.has("velocity links", 0.1);
    if (def.velocity_links || dice.has("velocity iterations", 0.05)) {
        solver.velocity_iterations = dice.integer("viterations", 0, 4);
    }
    if (def.velocity_links || dice.has("drift iterations", 0.1)) {
        solver.drift_iterations = dice.integer("diterations", 0, 3);
        solver.drift_correction = dice.uniform("drift correction", 0, 1);
    }
    if (dice.has("velocity damping", 0.3)) { solver.velocity_damping = dice.uniform("damping", 0, 0.2f); }
    if (dice.has("time scale", 0.1)) { solver.time_scale = dice.uniform("scale", 0.3f, 1.5f); }
    if (dice.has("collision margin", 0.4)) { def.collision_margin = dice.uniform("margin", 0.01f, 0.5f); }
}

void set_forces(const Dice& dice, const pli_mesh_view& mesh, scene_soft_def& def) {
    if (mesh.face_count == 0) { return; }
    if (dice.has("aero", 0.2)) {
        def.aero.model = static_cast<pli_aero_model>(dice.integer("aero model", 0, 6));
        def.aero.lift = dice.uniform("lift", 0, 0.1f);
        def.aero.drag = dice.uniform("drag", 0, 0.1f);
        if (dice.has("wind", 0.5)) { def.aero.wind = dice.vector("wind", 15.0f); }
    }
    if (dice.has("pressure", 0.15)) {
        def.pressure = dice.has("negative pressure", 0.2) ? dice.uniform("pressure", -20.0f, 0)
                                                          : std::exp(dice.uniform("pressure", -2.0f, 6.0f));
    }
    if (dice.has("volume", 0.15)) { def.volume_conservation = std::exp(dice.uniform("volume", -3.0f, 3.5f)); }
}

void set_contacts(const Dice& dice, bool is_one_piece, scene_soft_def& def) {
    const float friction = dice.has("friction", 0.5) ? dice.uniform("kDF", 0, 1.0f) : 0.2f;
    def.rigid_contacts.friction = def.soft_contacts.friction = def.cluster_contacts.friction = friction;
    def.has_rigid_contacts = dice.has("rigid contacts", 0.8);
    if (dice.has("hardness", 0.3)) {
        def.rigid_contacts.dynamic_hardness = dice.uniform("kCHR", 0, 1);
        def.rigid_contacts.static_hardness = dice.uniform("kKHR", 0, 1);
    }
    def.has_soft_contacts = is_one_piece && dice.has("soft contacts", 0.35);
    if (dice.has("soft hardness", 0.3)) { def.soft_contacts.hardness = dice.uniform("kSHR", 0, 1); }
    if (!def.has_clusters) { return; }
    // With both ways to meet the same things btSoftBody meets them in neither.
    def.cluster_contacts.with_rigids = !def.has_rigid_contacts && dice.has("cluster contacts with rigids", 0.7);
    def.cluster_contacts.with_bodies = !def.has_soft_contacts && dice.has("cluster contacts with bodies", 0.5);
    def.has_cluster_contacts = def.cluster_contacts.with_rigids || def.cluster_contacts.with_bodies;
    if (def.has_cluster_contacts && dice.has("cluster hardness", 0.5)) {
        def.cluster_contacts.dynamic_hardness = dice.uniform("kSRHR", 0, 1);
        def.cluster_contacts.static_hardness = dice.uniform("kSKHR", 0, 1);
        def.cluster_contacts.soft_hardness = dice.uniform("kSSHR", 0, 1);
        def.cluster_contacts.dynamic_split = dice.uniform("kSR_SPLT", 0, 1);
        def.cluster_contacts.static_split = dice.uniform("kSK_SPLT", 0, 1);
        def.cluster_contacts.soft_split = dice.uniform("kSS_SPLT", 0, 1);
    }
}

void set_clusters(const Dice& dice, const pli_mesh_view& mesh, scene_soft_def& def, Extras& extras) {
    def.has_clusters = dice.has("clusters", 0.35);
    if (!def.has_clusters) { return; }
    const bool has_elements = mesh.face_count + mesh.tetra_count > 0;
    def.cluster_count = has_elements && dice.has("clusters from elements", 0.2) ? 0 : dice.integer("count", 1, 8);
    if (dice.has("one cluster", 0.3)) { def.cluster_count = 1; }
    if (dice.has("cluster iterations", 0.2)) { extras.cluster_iterations = dice.integer("citerations", 1, 8); }
    pli_cluster_settings settings = {0, 0, 0, 0, true, 100.0f, 0.01f};
    extras.clusters.assign(static_cast<size_t>(std::max({16, mesh.face_count, mesh.tetra_count})), settings);
    for (size_t i = 0; i < extras.clusters.size(); ++i) {
        const Dice own = dice.has("settings of each cluster", 0.5) ? dice.part("cluster", static_cast<int>(i)) : dice;
        pli_cluster_settings& cluster = extras.clusters[i];
        if (own.share("matches") < 0.5 && dice.has("cluster matching", 0.4)) {
            cluster.matching = own.uniform("matching", 0, 0.5f);
        }
        if (own.share("damps") < 0.5 && dice.has("node damping", 0.4)) {
            cluster.node_damping = own.uniform("node damping", 0, 1);
        }
        if (own.share("slows") < 0.5 && dice.has("linear damping", 0.3)) {
            cluster.linear_damping = own.uniform("linear damping", 0, 1);
        }
        if (own.share("stops turns") < 0.5 && dice.has("angular damping", 0.3)) {
            cluster.angular_damping = own.uniform("angular damping", 0, 1);
        }
    }
}

void add_soft(Case& made, const Dice& dice) {
    demos::SoftRecord record;
    record.mesh = make_mesh(made.description.context, dice);
    record.name = "soft " + std::to_string(made.description.softs.size());
    record.def = scene_soft_def_default();
    const pli_mesh_view mesh = pli_mesh_get_view(record.mesh.get());
    Extras extras;
    set_solver(dice, record.def);
    set_forces(dice, mesh, record.def);
    set_clusters(dice, mesh, record.def, extras);
    set_contacts(dice, is_in_one_piece(mesh), record.def);
    if (dice.has("pose matching", 0.15)) { record.def.pose_matching = dice.uniform("kMT", 0, 0.5f); }
    record.velocity = dice.has("velocity", 0.5) ? dice.vector("velocity", 5.0f) : pli_vec3_make(0, 0, 0);
    if (dice.has("first force", 0.1)) {
        record.first_forces.push_back({dice.integer("pushed", 0, mesh.node_count - 1), dice.vector("force", 50.0f)});
    }
    if (dice.has("moved nodes", 0.15)) {
        extras.sets_state = dice.has("set state", 0.5);
        extras.move_step = dice.has("moved later", 0.5) ? dice.integer("move step", 1, 5) : 0;
        for (int i = 0; i < dice.integer("moves", 1, 5); ++i) {
            const std::string name = "move" + std::to_string(i);
            extras.moved_nodes.push_back({dice.integer(name, 0, mesh.node_count - 1), dice.vector(name, 0.5f)});
        }
    }
    record.order = static_cast<int>(made.description.rigids.size());
    made.description.softs.push_back(std::move(record));
    made.extras.push_back(std::move(extras));
}

// ------------------------------------------------------------------------------------------------ rigid bodies

void add_rigid(Case& made, const Dice& dice) {
    const int number = static_cast<int>(made.description.rigids.size());
    demos::RigidRecord record{};
    record.name = "rigid " + std::to_string(number);
    record.shape.kind = SCENE_SHAPE_SPHERE;
    record.shape.radius = 1;
    record.shape.margin = -1;
    const bool is_dynamic = dice.has("dynamic", 0.5);
    const auto kind = static_cast<random_shapes::Kind>(
        dice.integer("kind", 0, (is_dynamic ? random_shapes::movable_count : random_shapes::kind_count) - 1));
    dice.note(random_shapes::kind_name(kind));
    // Its own dice: the case that they note in is gone when shapes are made.
    record.shape.make_own = [dice, kind] { return random_shapes::make(dice, kind); };
    record.mass = is_dynamic ? std::exp(dice.uniform("mass", -2.0f, 4.0f)) : 0.0f;
    record.pose = pli_transform_make(dice.has("turned", 0.7) ? dice.turn("turn") : pli_quat_identity(),
                                     dice.vector("place", 1.8f));
    if (!is_dynamic) { record.pose.origin.y -= 0.8f; }
    record.friction = dice.uniform("friction", 0, 1.0f);
    if (!is_dynamic) { record.is_collision_only = dice.has("collision only", 0.3); }
    made.description.rigids.push_back(std::move(record));
}

void add_anchors(Case& made, const Dice& dice) {
    for (size_t i = 0; i < made.description.softs.size(); ++i) {
        demos::SoftRecord& soft = made.description.softs[i];
        const Dice own = dice.part("anchors", static_cast<int>(i));
        if (own.has("anchors", 0.2)) {
            for (int k = 0; k < own.integer("count", 1, 3); ++k) {
                const Dice each = own.part("anchor", k);
                const int rigids = static_cast<int>(made.description.rigids.size());
                const int rigid = each.integer("rigid", 0, rigids - 1);
                if (rigids == 0 || made.description.rigids[static_cast<size_t>(rigid)].is_collision_only) { continue; }
                const int nodes = pli_mesh_get_view(soft.mesh.get()).node_count;
                soft.anchors.push_back({each.integer("node", 0, nodes - 1), rigid, each.has("no collision", 0.3),
                                        each.has("influence", 0.3) ? each.uniform("influence", 0, 1) : 1.0f});
            }
        }
        if (own.has("anchor hardness", 0.3)) { soft.def.anchor_hardness = own.uniform("kAHR", 0, 1); }
    }
}

void add_joints(Case& made, const Dice& dice) {
    for (size_t i = 0; i < made.description.softs.size(); ++i) {
        const Dice own = dice.part("joint", static_cast<int>(i));
        if (!made.description.softs[i].def.has_clusters || !own.has("", 0.3)) { continue; }
        demos::JointRecord joint{};
        joint.is_angular = own.has("angular", 0.5);
        joint.ends = scene_joint_to_rigid(static_cast<int>(i), 0);
        const int softs = static_cast<int>(made.description.softs.size());
        const int other = own.integer("other", 0, softs - 1);
        if (other != static_cast<int>(i) && made.description.softs[static_cast<size_t>(other)].def.has_clusters) {
            joint.ends = scene_joint_to_soft(static_cast<int>(i), other);
        } else if (made.description.rigids.empty()) {
            continue;
        } else {
            joint.ends.rigid = own.integer("rigid", 0, static_cast<int>(made.description.rigids.size()) - 1);
        }
        if (own.has("softness", 0.5)) {
            joint.ends.softness = {own.uniform("erp", 0, 1), own.uniform("cfm", 0, 1), own.uniform("split", 0, 1)};
        }
        joint.position = own.vector("position", 2.0f);
        // btSoftBody takes the length of an axis for what it is.
        const pli_vec3 axis = pli_vec3_make(own.uniform("axis x", 0.2f, 1), own.uniform("axis y", -1, 1), 0.1f);
        joint.axis = pli_vec3_scale(axis, 1.0f / pli_vec3_length(axis));
        made.description.joints.push_back(joint);
    }
}

} // namespace

std::unique_ptr<Case> make(std::uint64_t key, const std::set<std::string>& off) {
    auto made = std::make_unique<Case>();
    const Dice dice(key, off, made->features);
    if (dice.has("step", 0.2)) { made->step_seconds = 1.0f / dice.uniform("steps per second", 20.0f, 240.0f); }
    if (dice.has("gravity", 0.2)) { made->description.gravity = dice.vector("gravity", 15.0f); }
    for (int i = 0; i < 7; ++i) {
        const Dice soft = dice.part("s", i), rigid = dice.part("r", i);
        if (i < 4 && rigid.has("", 0.5)) { add_rigid(*made, rigid); }
        if (i == 0 || (i < 3 && soft.has("", 0.35))) { add_soft(*made, soft); }
    }
    add_anchors(*made, dice);
    add_joints(*made, dice);
    return made;
}

} // namespace random_scene
