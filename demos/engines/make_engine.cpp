// The choice of an engine.

#include "bullet_engine.h"
#include "pliant_engine.h"

namespace demos {

std::unique_ptr<Engine> make_engine(EngineKind kind, const Description& description, const EngineOptions& options) {
    if (kind == EngineKind::bullet) { return std::make_unique<BulletEngine>(description, options); }
    return std::make_unique<PliantEngine>(description, options);
}

} // namespace demos
