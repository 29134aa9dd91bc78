// Film "gbuffer": colours and, of the first surfaces that the camera sees, their geometry, albedo and noise,
// in the channels and the order of pbrt-v4. The parameters of "rgb", and
//
//   "string coordinatesystem"  camera  or "world": space of P, N, Ns, dzdx, dzdy
//
// The channels are outputs of AovBuffer, with the same definitions as those of the command line.
#include "pbrt/film/aov.h"
#include "pbrt/film/render_state.h"
#include "pbrt/film/rgb.h"

namespace lacquer {
namespace {

AovSetup SetupOf(const Film& film, const FilmArgs& args) {
    AovSetup setup;
    setup.pixelBounds = film.PixelBounds();
    setup.spaces.color = &film.ColorSpace();
    setup.spaces.renderFromWorld = args.renderFromWorld;
    setup.spaces.renderFromCamera = args.renderFromCamera;
    setup.spaces.cameraSpace =
        args.params.GetChoice("coordinatesystem", "camera", {"camera", "world"}) == "camera";
    return setup;
}

class GBufferFilm final : public RGBFilm {
  public:
    explicit GBufferFilm(FilmArgs args)
        : RGBFilm({args.params, args.overrides, std::move(args.filter), args.shutterTime}),
          aovs_({"albedo", "position", "slope", "ng", "normal", "uv", "sensorvariance"},
                SetupOf(*this, args)) {
        RequireEXR("gbuffer", args.params, args.overrides);
    }

    FirstHitNeeds Needs() const override { return aovs_.Needs(); }
    void AddFirstHit(Int2 pixel, const FirstHit& hit, SampledSpectrum L,
                     const SampledWavelengths& lambda) override {
        aovs_.Add(pixel, hit, L, lambda, Response(L, lambda).value_or(Vec3(0)));
    }
    size_t MemoryBytes() const override { return RGBFilm::MemoryBytes() + aovs_.MemoryBytes(); }
    void AppendState(std::vector<StateArray>* arrays) override {
        RGBFilm::AppendState(arrays);
        aovs_.AppendState("film ", arrays);
    }
    std::unique_ptr<Image> Develop() const override { return aovs_.AppendTo(*RGBFilm::Develop()); }

  private:
    AovBuffer aovs_;
};

std::unique_ptr<Film> Create(FilmArgs args) { return std::make_unique<GBufferFilm>(std::move(args)); }

}  // namespace

LACQUER_REGISTER(FilmKind, "gbuffer", Create);

}  // namespace lacquer
