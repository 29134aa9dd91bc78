// Where the values of a JSON text stand: what its parser (nlohmann) forgets, for messages.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/error.h"

namespace lacquer {

/// Looks up places in a JSON text. Holds nothing but the text, and reads it anew at each call: for errors.
class JsonPlaces {
  public:
    /// @param text  valid JSON but for Deepest(); must outlive the object    @param file  its name
    JsonPlaces(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

    /// Line and column of a byte; columns count bytes.
    FileLoc LocOf(size_t byte) const;
    /// The place of the value that a JSON pointer [RFC 6901] names, "" being the whole and "/phase/3" an
    /// element of a member; of the last one on the way there that exists. Keys are compared as they are
    /// written, without escapes.
    FileLoc Find(std::string_view pointer) const;
    /// The place of the key of a member, of the last one that has it.
    FileLoc FindKey(std::string_view pointer, std::string_view key) const;
    /// The first key that its object has twice, or a place whose line is 0. One pass over the text.
    FileLoc FindRepeatedKey() const;
    /// The place where brackets are nested more than `limit` deep, or one whose line is 0. For any text.
    FileLoc FindDeeperThan(int limit) const;

  private:
    struct Entry {
        std::string_view key;  ///< of a member
        size_t keyAt, valueAt;
    };
    size_t SkipBlanks(size_t i) const;
    size_t SkipString(size_t i) const;
    size_t SkipValue(size_t i) const;
    /// Members of an object, elements of an array; nothing of other values.
    std::vector<Entry> Entries(size_t i) const;
    size_t FindByte(std::string_view pointer) const;

    std::string_view text_;
    std::string file_;
};

}  // namespace lacquer
