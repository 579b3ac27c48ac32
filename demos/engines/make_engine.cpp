// The choice of an engine.

#include "bullet_engine.h"

namespace demos {

std::unique_ptr<Engine> make_engine(EngineKind kind, const Description& description, const EngineOptions&) {
    if (kind == EngineKind::bullet) { return std::make_unique<BulletEngine>(description); }
    throw Error("unknown engine");
}

} // namespace demos
