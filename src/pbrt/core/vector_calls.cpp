#include "pbrt/core/vector_calls.h"

namespace lacquer {

#ifdef __AVX__
const char passesSpectraByRegister = 0;
#elif defined(__clang__)
const char passesSpectraByTwoRegisters = 0;
#else
const char passesSpectraByMemory = 0;
#endif

}  // namespace lacquer
