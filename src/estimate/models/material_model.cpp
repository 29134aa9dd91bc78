#include "estimate/models/material_model.h"

#include <array>

namespace lacquer::estimate {

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
