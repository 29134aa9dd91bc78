// Whole numbers of JSON values.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

namespace lacquer {

/// The number of `json`, if it is a whole one in the range of `Integer`: nlohmann's own conversions make some
/// int of 1e99, "undefined" by the standard, and of 3000000000. Errors: nlohmann::json::exception, as theirs.
template <class Integer, class Json>
Integer WholeNumber(const Json& json) {
    if (json.is_number_unsigned()) {
        if (const auto number = json.template get<uint64_t>(); std::in_range<Integer>(number))
            return Integer(number);
    } else if (json.is_number_integer()) {
        if (const auto number = json.template get<int64_t>(); std::in_range<Integer>(number))
            return Integer(number);
    }
    throw Json::out_of_range::create(406, "expected a whole number in range", &json);
}

/// The numbers of a list. Errors: those of WholeNumber().
template <class Integer, class Json>
std::vector<Integer> WholeNumbers(const Json& json) {
    if (!json.is_array()) throw Json::type_error::create(302, "expected a list", &json);
    std::vector<Integer> numbers;
    for (const Json& number : json) numbers.push_back(WholeNumber<Integer>(number));
    return numbers;
}

}  // namespace lacquer
