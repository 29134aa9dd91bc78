#include "cmd/mpi/scene_units.h"

#include "cmd/render/film_record.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/state_file.h"

namespace lacquer::cmd {
namespace {

/// Side of the tiles that threads take one after another: enough of them that all end at about one time.
int TileSide(const Bounds2i& pixels) {
    constexpr int kLargest = 16, kSmallest = 4, kTilesPerThread = 8;
    int side = kLargest;
    while (side > kSmallest && pixels.Area() < kTilesPerThread * AllowedThreads() * side * side) side /= 2;
    return side;
}

}  // namespace

RenderedUnit SceneUnits::Render(const RenderUnit& unit, Observer& observer) const {
    const Clock::time_point start = Clock::now();
    const std::unique_ptr<Film> part = MakePartOfFilm(film, *setup, unit.pixels);
    const std::unique_ptr<AovBuffer> outputs = MakeAovBuffer(aovs, cryptomatteRanks, *setup, unit.pixels);
    RenderOptions options = RenderOptionsOf(*setup);
    options.firstSample = unit.first;
    options.endSample = unit.end;
    options.halfBlock = halfBlock;
    options.tileOfOnePass = TileSide(unit.pixels);
    options.aovs = outputs.get();
    options.passes = passes;
    RenderedUnit rendered{unit, {}, {}};
    rendered.stats =
        lacquer::Render(*setup->scene, *setup->integrator, *setup->sampler, *part, options, observer);
    std::vector<StateArray> arrays;
    part->AppendState(&arrays);
    if (outputs) outputs->AppendState("outputs: ", &arrays);
    rendered.state = StateBytes("", arrays);
    rendered.stats.seconds = SecondsSince(start);
    return rendered;
}

}  // namespace lacquer::cmd
