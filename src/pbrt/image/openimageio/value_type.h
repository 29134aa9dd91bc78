// Types of values, in words of Lacquer and of OpenImageIO.
#pragma once

#include <OpenImageIO/typedesc.h>

#include "pbrt/image/image_library.h"

namespace lacquer::openimageio {

inline ValueType ValueTypeOf(OIIO::TypeDesc type) {
    if (type == OIIO::TypeUInt8) return ValueType::UInt8;
    if (type == OIIO::TypeUInt16) return ValueType::UInt16;
    if (type == OIIO::TypeHalf) return ValueType::Half;
    return type == OIIO::TypeFloat ? ValueType::Float : ValueType::Other;
}

inline OIIO::TypeDesc TypeDescOf(ValueType type) {
    switch (type) {
        case ValueType::UInt8:
            return OIIO::TypeUInt8;
        case ValueType::UInt16:
            return OIIO::TypeUInt16;
        case ValueType::Half:
            return OIIO::TypeHalf;
        case ValueType::Float:
            return OIIO::TypeFloat;
        case ValueType::Other:
            break;
    }
    return OIIO::TypeUnknown;
}

}  // namespace lacquer::openimageio
