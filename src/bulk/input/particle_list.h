// The arrangement "list" of particles.json: particles in given places.
#pragma once

#include "bulk/input/particles_json.h"

namespace lacquer::bulk {

/// Reads the particles at `pointer` into the ensemble, whose species and mode are known; in the mode
/// Aggregate the origin is in their middle. Errors: SceneError with line and column for particles that
/// overlap, or do not fit their species.
void ReadParticleList(const ParticlesJson& file, const std::string& pointer, BulkSettings* settings);

}  // namespace lacquer::bulk
