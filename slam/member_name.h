// The name of a struct's member, so that an option and its key share one name.
#pragma once

#include <string_view>

namespace slam {

/// The unqualified name of the member that a pointer to member points to: "sigma_m" for &Height::sigma_m.
template <auto Pointer>
constexpr std::string_view member_name() {
  constexpr std::string_view signature = __PRETTY_FUNCTION__;  // "... Pointer = &slam::Height::sigma_m; ..."
  constexpr std::string_view before = "Pointer = ";
  constexpr std::size_t start = signature.find(before) + before.size();
  constexpr std::string_view qualified =
      signature.substr(start, signature.find_first_of(";]", start) - start);
  return qualified.substr(qualified.rfind(':') + 1);
}

/// A pointer to member and the name of the member.
template <class Pointer>
struct Member {
  std::string_view name;
  Pointer pointer;
};

/// What a visitor of `keys` receives: `key.number(member<&Height::sigma_m>, 1e-9, 1e6, "...")`.
template <auto Pointer>
inline constexpr Member<decltype(Pointer)> member{member_name<Pointer>(), Pointer};

}  // namespace slam
