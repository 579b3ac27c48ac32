#ifndef PLIANT_BULLET_VEHICLE_RAYCASTER_H
#define PLIANT_BULLET_VEHICLE_RAYCASTER_H

/// Rays of vehicles among soft bodies.

#include <pliant/base.h>

#include <BulletDynamics/Vehicle/btVehicleRaycaster.h>

class btDynamicsWorld;

namespace pliant {

/// For a btRaycastVehicle in a world with soft bodies of a bridge. The rays of btDefaultVehicleRaycaster end at the
/// first object; where that is a soft body, which is no btRigidBody, the wheel has no ground. The rays of this one also
/// see through objects without contact response (CF_NO_CONTACT_RESPONSE), such as triggers.
///
///     pliant::VehicleRaycaster raycaster(world);
///     btRaycastVehicle vehicle(tuning, chassis, &raycaster);
class PLI_API VehicleRaycaster final : public btVehicleRaycaster {
public:
    /// What soft bodies are for wheels.
    enum class SoftBodies {
        ignored, ///< wheels roll on what is below: cloth on the floor, grass, ropes
        ground   ///< wheels roll on them as on something that does not move, and do not press on them
    };

    /// @param world has to outlive it
    explicit VehicleRaycaster(btDynamicsWorld& world, SoftBodies soft_bodies = SoftBodies::ignored);

    /// Called by the vehicle for each wheel.
    /// @return null for no ground
    void* castRay(const btVector3& from, const btVector3& to, btVehicleRaycasterResult& result) override;

    int filter_group = 1; ///< Bullet's collision filter of the rays, default DefaultFilter
    int filter_mask = -1; ///< default AllFilter

private:
    btDynamicsWorld& world_;
    SoftBodies soft_bodies_;
};

} // namespace pliant

#endif
