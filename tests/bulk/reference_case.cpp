#include "bulk/reference_case.h"

#include <fstream>

namespace lacquer::test {

using namespace bulk;

ReferenceCase ReferenceCase::Read(const std::string& name) {
    std::ifstream file(std::string(LACQUER_SOURCE_DIR "/tests/bulk/data/") + name + ".json");
    ReferenceCase found{{}, nlohmann::json::parse(file)};
    for (const auto& s : found.numbers.at("spheres")) {
        const Point center(s["pos"][0], s["pos"][1], s["pos"][2]);
        found.spheres.push_back(MakeSphere(center, s["x"], {s["m"][0], s["m"][1]}));
    }
    return found;
}

Solved::Solved(Cluster solvedCluster, Direction n, double residual)
    : cluster(std::move(solvedCluster)), incident(IncidentWaves(cluster, n)) {
    scattered = ClusterSolver(cluster).Solve(incident, {.residual = residual});
    far = AboutOrigin(cluster, scattered.coefficients, FarFieldDegree(cluster));
}

}  // namespace lacquer::test
