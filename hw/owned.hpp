// An owning pointer to an object of a C library; frees it with the matching function of that library.
#pragma once

#include <memory>

namespace contourd {

template <auto kFree>
struct FreeBy {
  template <typename Type>
  void operator()(Type* object) const {
    kFree(object);
  }
};
template <typename Type, auto kFree>
using Owned = std::unique_ptr<Type, FreeBy<kFree>>;

}  // namespace contourd
