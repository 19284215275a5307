// An owning pointer to an object that libdrm allocated; frees it with the matching libdrm function.
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
using LibdrmPointer = std::unique_ptr<Type, FreeBy<kFree>>;

}  // namespace contourd
