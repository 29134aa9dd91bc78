#include "pbrt/film/manifest.h"

#include <nlohmann/json.hpp>

namespace lacquer {

std::string JsonManifest(std::span<const std::string> names,
                         const std::function<std::string(size_t)>& value) {
    std::string text = "{";
    for (size_t i = 0; i < names.size(); ++i) {
        if (i > 0) text += ',';
        text += nlohmann::json(names[i]).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
        text += ':' + value(i);
    }
    return text + "}";
}

}  // namespace lacquer
