#include <cstdio>

#include "measure/scene_material.h"

int main(int, char** argv) {
    using namespace lacquer;
    const measure::SceneMaterial material = measure::LoadMaterial(argv[1], argv[2]);
    const Vec3 wo(-0.6f, 0, 0.8f), wi(0, 0.6f, 0.8f);
    Rng rng(1);
    const auto f = material.bsdf->Evaluate(wo, wi, TransportMode::Radiance, 4096, rng);
    std::printf("%.7f %.7f %.7f %.7f\n", f.Mean().x, f.Mean().y, f.Mean().z, f.LuminanceError());
}
