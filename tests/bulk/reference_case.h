// Clusters with known numbers, in tests/bulk/data: by a prototype in another language, and by MSTM 4.0
// [Mackowski and Mishchenko 2011].
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bulk/averages/scattering_sums.h"
#include "bulk/cluster/cluster.h"
#include "bulk/cluster/far_field.h"

namespace lacquer::test {

struct ReferenceCase {
    std::vector<bulk::Sphere> spheres;
    nlohmann::json numbers;  ///< "prototype" and "mstm", each by incidence

    static ReferenceCase Read(const std::string& name);
};

/// A cluster solved to 1e-12 for light along (theta, 0), with what follows from it.
struct Solved {
    bulk::Cluster cluster;
    bulk::HelicityWaves incident;
    bulk::ScatteredWaves scattered;
    bulk::OneOriginWaves far;

    Solved(bulk::Cluster solvedCluster, bulk::Direction n, double residual = 1e-12);
    bulk::CrossSection Extinction() const {
        return bulk::ExtinctionOf(cluster, scattered.coefficients, incident);
    }
    bulk::CrossSection Absorption() const { return bulk::AbsorptionOf(cluster, scattered.coefficients); }
};

}  // namespace lacquer::test
