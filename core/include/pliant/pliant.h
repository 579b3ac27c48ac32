#ifndef PLIANT_PLIANT_H
#define PLIANT_PLIANT_H

/// Everything but bullet_reference.h.

#include "anchor.h"
#include "base.h"
#include "body.h"
#include "cluster.h"
#include "contact.h"
#include "contact_events.h"
#include "cut.h"
#include "drag.h"
#include "drawing.h"
#include "forces.h"
#include "generate.h"
#include "implicit.h"
#include "io.h"
#include "joint.h"
#include "limits.h"
#include "math.h"
#include "mesh.h"
#include "pose.h"
#include "query.h"
#include "rigid.h"
#include "self_collision.h"
#include "shape.h"
#include "snapshot.h"
#include "target.h"
#include "tether.h"
#include "threads.h"
#include "world.h"
#include "world_file.h"
#include "xpbd.h"

#endif
