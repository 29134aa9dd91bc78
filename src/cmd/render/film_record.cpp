#include "cmd/render/film_record.h"

#include "pbrt/core/json_number.h"
#include "pbrt/film/cryptomatte.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/scene/factory.h"

namespace lacquer::cmd {
namespace {

using nlohmann::ordered_json;

ordered_json ToJson(const PluginEntity& entity) {
    ordered_json parameters = ordered_json::array();
    for (const Parameter& p : entity.parameters) {
        ordered_json json = {{"type", p.type}, {"name", p.name}};
        if (!p.floats.empty()) json["floats"] = p.floats;
        if (!p.integers.empty()) json["integers"] = p.integers;
        if (!p.strings.empty()) json["strings"] = p.strings;
        if (!p.bools.empty()) json["bools"] = p.bools;
        parameters.push_back(std::move(json));
    }
    return {{"type", entity.type}, {"parameters", parameters}};
}

PluginEntity EntityOf(const ordered_json& json, const ColorSpace* colorSpace) {
    PluginEntity entity;
    entity.type = json.at("type");
    entity.colorSpace = colorSpace;
    const auto read = [](const ordered_json& from, const char* name, auto* values) {
        if (from.contains(name)) from[name].get_to(*values);
    };
    for (const ordered_json& from : json.at("parameters")) {
        Parameter p;
        p.type = from.at("type");
        p.name = from.at("name");
        if (const ParameterType* type = FindParameterType(p.type)) p.kind = type->values;
        read(from, "floats", &p.floats);
        if (from.contains("integers")) p.integers = WholeNumbers<int>(from["integers"]);
        read(from, "strings", &p.strings);
        read(from, "bools", &p.bools);
        p.colorSpace = colorSpace;
        entity.parameters.push_back(std::move(p));
    }
    return entity;
}

ordered_json ToJson(const MetadataValue& value) {
    if (const int* number = std::get_if<int>(&value)) return *number;
    const auto& matrix = std::get<glm::mat4>(value);
    ordered_json numbers = ordered_json::array();
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) numbers.push_back(matrix[column][row]);
    return numbers;
}

MetadataValue MetadataOf(const ordered_json& json) {
    if (json.is_number_integer()) return WholeNumber<int>(json);
    glm::mat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = json.at(size_t(i)).get<float>();
    return matrix;
}

/// Of a film that renders; one that only adds up and develops needs none.
struct FilmSpaces {
    Transform renderFromWorld = {};
    AnimatedTransform renderFromCamera = {};
};

std::unique_ptr<Film> MakeFilm(const ordered_json& record, FilmOverrides overrides,
                               const FilmSpaces& spaces = {}) {
    const ColorSpace* colorSpace = ColorSpace::Find(record.at("colorSpace").get<std::string>());
    if (!colorSpace) throw SceneError({}, "the film's colour space is unknown to this program");
    const PluginEntity film = EntityOf(record.at("film"), colorSpace);
    const PluginEntity filter = EntityOf(record.at("filter"), colorSpace);
    const Params params = MakeParams(film, FilmKind::kKind, {});
    const ordered_json& resolution = record.at("resolution");
    overrides.resolution = Int2(WholeNumber<int>(resolution.at(0)), WholeNumber<int>(resolution.at(1)));
    overrides.keepsHalves = record.at("halves");
    return FactoryOf<FilmKind>(film)(
        {params, overrides, FactoryOf<FilterKind>(filter)(MakeParams(filter, FilterKind::kKind, {})),
         record.at("shutterTime"), spaces.renderFromWorld, spaces.renderFromCamera});
}

/// As --cryptomatte-ranks takes them.
int CryptomatteRanks(const ordered_json& json) {
    const int ranks = WholeNumber<int>(json);
    if (!CryptomatteLayer::CanHave(ranks))
        throw ordered_json::out_of_range::create(
            406, fmt::format("expected an even number from 2 to {}", CryptomatteLayer::kMaxRanks), &json);
    return ranks;
}

}  // namespace

ordered_json FilmDirectives(const SceneDescription& d) {
    return {
        {"film", ToJson(d.film)},
        {"filter", ToJson(d.filter)},
        {"colorSpace", d.film.colorSpace ? d.film.colorSpace->Name() : ColorSpace::SRGB().Name()},
        {"shutterTime", Camera::ShutterTime(MakeParams(d.camera, CameraKind::kKind, d.FilesOf(d.camera)))},
        {"integrator", d.integrator.type},
        {"sampler", d.sampler.type}};
}

ordered_json FilmRecord(ordered_json directives, const RenderSetup& setup, const AovBuffer* aovs,
                        int cryptomatteRanks, const PassSet* passes) {
    ordered_json& record = directives;
    const std::vector<std::string> none, outputs = aovs ? aovs->OutputNames() : none;
    record["resolution"] = {setup.film->Resolution().x, setup.film->Resolution().y};
    record["halves"] = AovBuffer::NeedsHalves(outputs);
    record["splats"] = setup.integrator->MakesSplats();
    record["outputs"] = outputs;
    record["cryptomatteRanks"] = cryptomatteRanks;
    record["passes"] = passes ? passes->Layers() : none;
    std::vector<std::string> materials;
    for (const auto& [material, name] : setup.scene->Names().materials) materials.push_back(name);
    record["objects"] = setup.scene->Names().objects;
    record["materials"] = materials;
    for (const auto& [name, value] : SceneMetadata(setup)) record["metadata"][name] = ToJson(value);
    return record;
}

void CheckFilmRecord(const ordered_json& record) {
    using Names = std::vector<std::string>;
    record.at("film").at("type").get<std::string>();
    for (const char* name : {"integrator", "sampler"}) record.at(name).get<std::string>();
    for (const char* name : {"outputs", "passes"}) record.at(name).get<Names>();
    for (const size_t axis : {size_t(0), size_t(1)}) WholeNumber<int>(record.at("resolution").at(axis));
    record.at("splats").get<bool>();
}

bool MakesSplats(const ordered_json& record) { return record.at("splats"); }

RestoredFilm RestoreFilm(const ordered_json& record, FilmOverrides overrides) {
    RestoredFilm restored;
    restored.film = MakeFilm(record, std::move(overrides));
    restored.names = std::make_unique<SceneNames>();
    record.at("objects").get_to(restored.names->objects);
    for (const ordered_json& name : record.at("materials"))
        restored.names->materials.emplace_back(nullptr, name.get<std::string>());
    const std::vector<std::string> outputs = record.at("outputs"), passes = record.at("passes");
    if (!outputs.empty()) {
        AovSetup setup;
        setup.pixelBounds = restored.film->PixelBounds();
        setup.spaces.color = &restored.film->ColorSpace();
        setup.names = restored.names.get();
        setup.cryptomatteRanks = CryptomatteRanks(record.at("cryptomatteRanks"));
        restored.aovs = std::make_unique<AovBuffer>(outputs, setup);
    }
    restored.hasPasses = !passes.empty();
    if (restored.hasPasses) restored.film->KeepPasses(passes);
    if (MakesSplats(record)) restored.film->PrepareForSplats(1);
    for (const auto& [name, value] : record.at("metadata").items())
        restored.metadata[name] = MetadataOf(value);
    return restored;
}

std::unique_ptr<Film> MakePartOfFilm(const ordered_json& record, const RenderSetup& setup,
                                     const Bounds2i& pixels) {
    FilmOverrides overrides;
    overrides.pixelBounds = pixels;
    overrides.filename = setup.film->Filename();
    std::unique_ptr<Film> film =
        MakeFilm(record, overrides, {setup.renderFromWorld, setup.scene->Camera().RenderFromCamera()});
    const std::vector<std::string> passes = record.at("passes");
    if (!passes.empty()) film->KeepPasses(passes);
    return film;
}

std::vector<StateArray> RestoredFilm::State() const {
    std::vector<StateArray> arrays;
    film->AppendState(&arrays);
    if (aovs) aovs->AppendState("outputs: ", &arrays);
    return arrays;
}

}  // namespace lacquer::cmd
