// A plugin that exists for the length of a test.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "pbrt/core/registry.h"

namespace lacquer::test {

/// Registers a made-up plugin, and takes it back at the end: what lists registered names does not see it
/// later.
template <class Kind>
class ScopedRegistration {
  public:
    ScopedRegistration(std::string name, typename Kind::Factory factory,
                       typename Registry<Kind>::Traits traits = {})
        : name_(std::move(name)) {
        EXPECT_TRUE(Registry<Kind>::Add(name_, factory, traits)) << name_;
    }
    ~ScopedRegistration() { Registry<Kind>::Remove(name_); }
    ScopedRegistration(const ScopedRegistration&) = delete;
    ScopedRegistration& operator=(const ScopedRegistration&) = delete;

  private:
    std::string name_;
};

}  // namespace lacquer::test
