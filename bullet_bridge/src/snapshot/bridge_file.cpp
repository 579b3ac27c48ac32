// Moments as files: the core's world as the core writes it, and Bullet's side by places in the list of its objects.

#include "bridge_moment.h"

#include <pliant/limits.h>
#include <pliant/world_file.h>

#include <cmath>
#include <cstdint>
#include <cstring>

namespace pliant {

namespace {

// Bullet's numbers are as this build of Bullet has them.
struct Header {
    char magic[8];
    std::uint32_t version, scalar_size, point_size, object_count, contact_count, activation_count;
    std::uint64_t core_size;
    std::uint64_t checksum; ///< see checksum_of()
};
constexpr char file_magic[8] = {'P', 'L', 'I', 'B', 'R', 'I', 'D', 'G'};
constexpr std::uint32_t file_version = 4;

// Of what follows the core's file, which has its own.
std::uint64_t checksum_of(const unsigned char* bytes, std::size_t size) {
    std::uint64_t sum = 14695981039346656037u;
    for (std::size_t i = 0; i < size; ++i) {
        sum = (sum ^ bytes[i]) * 1099511628211u;
    }
    return sum;
}

class Writer {
public:
    explicit Writer(std::vector<unsigned char>& bytes) : bytes_(bytes) {}
    void put(const void* data, std::size_t size) {
        const auto* first = static_cast<const unsigned char*>(data);
        bytes_.insert(bytes_.end(), first, first + size);
    }
    template <typename T> void put(const T& value) { put(&value, sizeof value); }

private:
    std::vector<unsigned char>& bytes_;
};

class Reader {
public:
    Reader(const unsigned char* bytes, std::size_t size) : bytes_(bytes), left_(size) {}
    const unsigned char* take(std::size_t size) {
        if (size > left_) {
            is_short_ = true;
            return nullptr;
        }
        const unsigned char* taken = bytes_;
        bytes_ += size;
        left_ -= size;
        return taken;
    }
    template <typename T> void get(T& value) {
        const unsigned char* taken = take(sizeof value);
        if (taken != nullptr) { std::memcpy(static_cast<void*>(&value), taken, sizeof value); }
    }
    bool is_at_end() const { return !is_short_ && left_ == 0; }
    bool is_short() const { return is_short_; }
    std::size_t left() const { return left_; }

private:
    const unsigned char* bytes_;
    std::size_t left_;
    bool is_short_ = false;
};

// One after the other, of an object: the same for both directions. Vectors are numbers without addresses.
template <typename Stream> void object_state(Stream&& stream, ObjectState& state) {
    stream(state.identity.type);
    stream(state.identity.group);
    stream(state.identity.mask);
    stream(state.pose);
    stream(state.interpolation_pose);
    stream(state.interpolation_linear_velocity);
    stream(state.interpolation_angular_velocity);
    stream(state.activation);
    stream(state.deactivation_time);
    stream(state.hit_fraction);
    stream(state.linear_velocity);
    stream(state.angular_velocity);
    stream(state.force);
    stream(state.torque);
    stream(state.gravity);
    stream(state.inverse_inertia);
}

int place_of(const btCollisionObjectArray& array, const btCollisionObject* object) {
    for (int i = 0; i < array.size(); ++i) {
        if (array[i] == object) { return i; }
    }
    return -1;
}

constexpr std::uint64_t no_place = UINT64_MAX;

} // namespace

// Callbacks of the core see what BridgeSnapshot may see.
struct BridgeSnapshot::Naming {
    const Bridge::Impl& bridge;
    const btCollisionObjectArray& array;

    static std::uint64_t id(const pli_rigid* rigid, void* user) {
        const auto& self = *static_cast<const Naming*>(user);
        for (int i = 0; i < self.array.size(); ++i) {
            if (self.bridge.known_rigid(*self.array[i]) == rigid) { return static_cast<std::uint64_t>(i); }
        }
        return no_place;
    }
    static pli_rigid* find(std::uint64_t id, void* user) {
        const auto& self = *static_cast<const Naming*>(user);
        if (id >= static_cast<std::uint64_t>(self.array.size())) { return nullptr; }
        return self.bridge.known_rigid(*self.array[static_cast<int>(id)]);
    }
    pli_world_file_def def() {
        pli_world_file_def made = pli_world_file_def_default();
        made.rigid_id = id;
        made.find_rigid = find;
        made.user = this;
        return made;
    }
};

pli_status BridgeSnapshot::write_file(const Bridge& bridge, std::vector<unsigned char>& bytes) {
    bytes.clear();
    btDiscreteDynamicsWorld* world = bridge.impl_->bullet_world_between_steps();
    if (world == nullptr) { return bridge.impl_->fail_between_steps("pliant::BridgeSnapshot::write_file"); }
    Moment moment;
    bridge.impl_->save_knowledge(moment.bridge);
    moment.take(*world);
    const btCollisionObjectArray& array = world->getCollisionObjectArray();
    Naming naming{*bridge.impl_, array};
    const pli_world_file_def def = naming.def();
    std::vector<unsigned char> core(pli_world_file_size(bridge.world()));
    const pli_status status = pli_world_file_write(bridge.world(), &def, core.data(), core.size(), nullptr);
    if (status != PLI_OK) { return status; }

    Header header{};
    std::memcpy(header.magic, file_magic, sizeof header.magic);
    header.version = file_version;
    header.scalar_size = sizeof(btScalar);
    header.point_size = sizeof(btManifoldPoint);
    header.object_count = static_cast<std::uint32_t>(moment.objects.size());
    header.contact_count = static_cast<std::uint32_t>(moment.contacts.size());
    header.activation_count = static_cast<std::uint32_t>(moment.bridge.activations.size());
    header.core_size = core.size();
    Writer writer(bytes);
    writer.put(header);
    writer.put(core.data(), core.size());
    for (ObjectState& state : moment.objects) {
        object_state([&](auto& value) { writer.put(value); }, state);
    }
    for (const Points& points : moment.contacts) {
        const std::int32_t places[3] = {place_of(array, points.bodies[0]), place_of(array, points.bodies[1]),
                                        points.count};
        writer.put(places);
        writer.put(points.points, static_cast<std::size_t>(points.count) * sizeof points.points[0]);
    }
    for (const Bridge::Impl::Knowledge::Activation& activation : moment.bridge.activations) {
        const unsigned char flags[3] = {activation.is_frozen_by_bridge, activation.wants_sleep, activation.is_asleep};
        writer.put(flags);
    }
    for (const Hold& hold : moment.bridge.holds) {
        writer.put(hold);
    }
    const pli_vec3 none{0, 0, 0};
    writer.put(static_cast<unsigned char>(moment.bridge.followed_gravity.has_value()));
    writer.put(moment.bridge.followed_gravity.value_or(none));
    writer.put(moment.gravity);
    writer.put(moment.accumulated_time);
    writer.put(static_cast<std::uint64_t>(moment.seed));
    header.checksum =
        checksum_of(bytes.data() + sizeof header + core.size(), bytes.size() - sizeof header - core.size());
    std::memcpy(bytes.data(), &header, sizeof header);
    return PLI_OK;
}

namespace {

// Null when it is sound.
const char* find_fault_of_header(const unsigned char* bytes, std::size_t size, Header& header) {
    if (size < sizeof header) { return "it is shorter than its header"; }
    std::memcpy(&header, bytes, sizeof header);
    if (std::memcmp(header.magic, file_magic, sizeof file_magic) != 0) { return "it is no file of a bridge"; }
    if (header.version != file_version) { return "it has the format of another version"; }
    if (header.scalar_size != sizeof(btScalar) || header.point_size != sizeof(btManifoldPoint)) {
        return "it is of a Bullet in another precision or version";
    }
    if (header.core_size > size - sizeof header) { return "it is cut short"; }
    const unsigned char* after_core = bytes + sizeof header + header.core_size;
    const std::size_t size_after_core = size - sizeof header - header.core_size;
    const bool is_whole = header.checksum == checksum_of(after_core, size_after_core);
    return is_whole ? nullptr : "its checksum is wrong, it is cut short or damaged";
}

constexpr char fault_of_lists[] = "a list in it is cut short or out of range";
constexpr char fault_of_objects[] = "the Bullet world has other objects";

} // namespace

// Of Bullet's side; the objects are those of now.
const char* BridgeSnapshot::Moment::read(const btCollisionObjectArray& array, std::size_t activation_count,
                                         const unsigned char* bytes, std::size_t size) {
    Header header{};
    if (const char* fault = find_fault_of_header(bytes, size, header)) { return fault; }
    Reader reader(bytes + sizeof header + header.core_size, size - sizeof header - header.core_size);
    if (header.object_count != static_cast<std::uint32_t>(array.size()) ||
        header.activation_count != activation_count) {
        return fault_of_objects;
    }
    for (int i = 0; i < array.size(); ++i) {
        ObjectState state(*array[i]);
        const FollowedObject now = state.identity;
        object_state([&](auto& value) { reader.get(value); }, state);
        if (reader.is_short()) { return fault_of_lists; }
        if (!(state.identity == now)) { return fault_of_objects; }
        objects.push_back(state);
    }
    for (std::uint32_t i = 0; i < header.contact_count && !reader.is_short(); ++i) {
        std::int32_t places[3] = {-1, -1, -1};
        reader.get(places);
        const bool is_sound = places[0] >= 0 && places[0] < array.size() && places[1] >= 0 &&
                              places[1] < array.size() && places[2] > 0 && places[2] <= MANIFOLD_CACHE_SIZE;
        if (!is_sound) { return fault_of_lists; }
        Points& points = contacts.emplace_back();
        points.bodies[0] = array[places[0]];
        points.bodies[1] = array[places[1]];
        points.count = places[2];
        for (int k = 0; k < points.count; ++k) {
            reader.get(points.points[k]);
            points.points[k].m_userPersistentData = nullptr;
        }
    }
    for (std::uint32_t i = 0; i < header.activation_count && !reader.is_short(); ++i) {
        unsigned char flags[3] = {};
        reader.get(flags);
        bridge.activations.push_back({flags[0] != 0, flags[1] != 0, flags[2] != 0});
    }
    bridge.holds.resize(objects.size());
    for (Hold& hold : bridge.holds) {
        reader.get(hold);
    }
    unsigned char has_gravity = 0;
    pli_vec3 followed{};
    std::uint64_t read_seed = 0;
    reader.get(has_gravity);
    reader.get(followed);
    reader.get(gravity);
    reader.get(accumulated_time);
    reader.get(read_seed);
    if (has_gravity != 0) { bridge.followed_gravity = followed; }
    this->seed = static_cast<unsigned long>(read_seed);
    if (!reader.is_at_end()) { return fault_of_lists; }
    // With an endless time in its accumulator Bullet would never step again.
    const bool has_time = btFabs(accumulated_time) <= btScalar(PLI_MAX_TIME_STEP);
    return has_time && std::isfinite(gravity.length2()) ? nullptr : "its time or gravity is out of range";
}

pli_status BridgeSnapshot::read_file(Bridge& bridge, const unsigned char* bytes, std::size_t size) {
    btDiscreteDynamicsWorld* world = bridge.impl_->bullet_world_between_steps();
    const char* const function = "pliant::BridgeSnapshot::read_file";
    if (world == nullptr) { return bridge.impl_->fail_between_steps(function); }
    if (bytes == nullptr) { return bridge.impl_->fail(PLI_ERROR_NULL_ARGUMENT, function, "bytes is null"); }
    Bridge::Impl::Knowledge now;
    bridge.impl_->save_knowledge(now); // makes the proxies that the file names
    const btCollisionObjectArray& array = world->getCollisionObjectArray();
    Moment moment;
    if (const char* fault = moment.read(array, now.activations.size(), bytes, size)) {
        const bool is_other_world = fault == fault_of_objects;
        return bridge.impl_->fail(is_other_world ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_FILE_FORMAT, function, fault);
    }
    Header header{};
    std::memcpy(&header, bytes, sizeof header);
    Naming naming{*bridge.impl_, array};
    const pli_world_file_def def = naming.def();
    const pli_status status = pli_world_file_restore(bridge.world(), &def, bytes + sizeof header, header.core_size);
    if (status != PLI_OK) { return status; }
    restore_bullet(bridge, *world, moment, true);
    return PLI_OK;
}

} // namespace pliant
