#include "pbrt/scene/attribute_reads.h"

namespace lacquer {

namespace {

auto PlaceOf(const FileLoc& loc) { return std::tuple(loc.file, loc.line, loc.column); }

}  // namespace

void AttributeReads::Note(const Params& params) {
    if (!params.HasAttributes()) return;
    for (const Parameter& p : params.All())
        if (p.fromAttribute && p.lookedUp) reads_[PlaceOf(p.loc)] = std::nullopt;
    for (Diagnostic& unread : params.UnusedAttributes()) {
        const auto place = PlaceOf(unread.loc);
        reads_.try_emplace(place, std::move(unread));
    }
}

std::vector<Diagnostic> AttributeReads::Unread() const {
    std::vector<Diagnostic> unread;
    for (const auto& [place, diagnostic] : reads_)
        if (diagnostic) unread.push_back(*diagnostic);
    return unread;
}

}  // namespace lacquer
