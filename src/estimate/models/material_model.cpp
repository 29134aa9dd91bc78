#include "estimate/models/material_model.h"

#include <array>

namespace lacquer::estimate {

std::span<const std::string_view> CellKindNames() {
    static constexpr std::array<std::string_view, kNumCellKinds> kNames{"jittered", "poisson-disc",
                                                                        "stretched"};
    return kNames;
}
std::span<const std::string_view> NoiseKindNames() {
    static constexpr std::array<std::string_view, kNumNoiseKinds> kNames{"spectral", "band-limited",
                                                                         "ridged"};
    return kNames;
}

Surface MakeSurface(const MaterialModel& model, const MapGrid& grid, const ModelKinds& kinds,
                    std::span<const double> parameters, uint64_t seed) {
    const auto run = model.MakeRun(grid, kinds, parameters);
    run->SetSeed(seed);
    Surface surface;
    run->Forward(parameters, &surface);
    return surface;
}

int MaterialModel::Find(std::string_view name) const {
    const auto table = Parameters();
    for (size_t i = 0; i < table.size(); ++i)
        if (table[i].name == name) return int(i);
    return -1;
}

std::span<const MaterialModel* const> AllModels() {
    static const std::array<const MaterialModel*, 6> kModels{&BumpModel(),  &LeatherModel(), &PlasterModel(),
                                                             &MetalModel(), &FlakesModel(),  &WoodModel()};
    return kModels;
}

const MaterialModel* FindModel(std::string_view name) {
    for (const MaterialModel* model : AllModels())
        if (model->Name() == name) return model;
    return nullptr;
}

}  // namespace lacquer::estimate
