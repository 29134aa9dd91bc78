#include "capture/views.h"

namespace lacquer::capture {

ColorEncoding EncodingOf(Response response) {
    switch (response) {
        case Response::Gamma22:
            return {ColorEncoding::Kind::Gamma, 2.2F};
        case Response::SRGB:
            return {ColorEncoding::Kind::SRGB, 1};
        default:
            return {ColorEncoding::Kind::Linear, 1};
    }
}

}  // namespace lacquer::capture
