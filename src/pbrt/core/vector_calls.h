// That all objects of a program pass spectra alike. They are vectors of 32 bytes, which go by register where
// there is AVX, else by memory, or by two registers if Clang compiles, and nobody is told where objects
// differ in that. So each names its way, which only a library of the same way defines: others do not link.
// For headers that programs of others include.
#pragma once

namespace lacquer {

extern const char passesSpectraByRegister, passesSpectraByTwoRegisters, passesSpectraByMemory;
[[gnu::used]] inline const char* const kVectorCalls =
#ifdef __AVX__
    &passesSpectraByRegister;
#elif defined(__clang__)
    &passesSpectraByTwoRegisters;
#else
    &passesSpectraByMemory;
#endif

}  // namespace lacquer
