// Headers of states, as --resume, merge and info read them.
#include "cmd/render/state_header.h"
#include "cmd/render/film_record.h"
#include "cmd/render/state_info.h"
#include "fuzz/fuzz_target.h"
#include "pbrt/base/film.h"
#include "pbrt/core/error.h"

namespace lacquer::fuzz {
namespace {

/// Merging makes the film of the whole image, which may be large by right.
void RestoreSmallFilm(const nlohmann::ordered_json& record) {
    const auto& resolution = record["resolution"];
    if (resolution[0].get<int>() > 64 || resolution[1].get<int>() > 64) return;
    try {
        cmd::RestoreFilm(record, {}).State();
    } catch (const nlohmann::json::exception&) {  // as merge takes them
        throw FileError("a.state", "is no state");
    } catch (const OverrideError&) {
        throw FileError("a.state", "is of no pixels");
    }
}

void HeaderOfState(std::string_view bytes) {
    const cmd::StateHeader header = cmd::StateHeader::Read("a.state", std::string(bytes));
    const cmd::StateHeader again = cmd::StateHeader::Read("a.state", header.Text());
    Require(cmd::Difference(header, again).empty(), "a header that is written is read again");
    cmd::StateInfoText({"a.state", header});
    RestoreSmallFilm(header.film);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "state_header", HeaderOfState);

}  // namespace lacquer::fuzz
