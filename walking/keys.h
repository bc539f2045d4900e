// Keys of options: `number<&Gyro::sigma_rad_s>(key, lowest, highest, "what it means")` in a struct's function
// `keys` names a key after the member and passes it to a visitor.
#pragma once

#include <string>
#include <string_view>

namespace walking {

template <auto Member>
constexpr const char* signature_with() {
  return __PRETTY_FUNCTION__;
}

/// Returns the name of a pointer to member: "sigma_rad_s" for &Gyro::sigma_rad_s.
template <auto Member>
constexpr std::string_view member_name() {
  std::string_view text =
      signature_with<Member>();  // GCC and clang end it with "= &slam::Gyro::sigma_rad_s]"
  text = text.substr(0, text.find_last_not_of("]);") + 1);
  return text.substr(text.rfind(':') + 1);
}

/// Base of the visitors of `keys`, so that argument-dependent lookup finds the functions below. A visitor
/// implements the same functions with the name and member as the first arguments: `number("sigma_rad_s",
/// &Gyro::sigma_rad_s, ...)`.
struct KeyVisitor {};

/// A number, or a list of numbers, within a range.
template <auto Member>
void number(auto& visitor, double lowest, double highest, const char* doc) {
  visitor.number(member_name<Member>(), Member, lowest, highest, doc);
}
/// An angle: the key `angle_deg` of the member `angle_rad`.
template <auto Member>
void degrees(auto& visitor, double lowest, double highest, const char* doc) {
  constexpr std::string_view name = member_name<Member>();
  static_assert(name.ends_with("_rad"));
  visitor.degrees(std::string(name.substr(0, name.size() - 3)) + "deg", Member, lowest, highest, doc);
}
/// An enumerator, a word or a list of words.
template <auto Member>
void choice(auto& visitor, const auto& words, const char* doc) {
  visitor.choice(member_name<Member>(), Member, words, doc);
}
/// A switch, an unsigned integer, a name or a list of items.
template <auto Member>
void value(auto& visitor, const char* doc) {
  visitor.value(member_name<Member>(), Member, doc);
}
/// Nested options.
template <auto... Members>
void part(auto& visitor) {
  (visitor.part(member_name<Members>(), Members), ...);
}

}  // namespace walking
