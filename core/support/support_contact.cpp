#include "core/support/support_contact.hpp"

namespace contourd {

std::string_view name_of(ContactCause cause) {
  switch (cause) {
    case ContactCause::Island:
      return "island";
    case ContactCause::Overhang:
      return "overhang";
    case ContactCause::Peel:
      return "peel";
  }
  return "unknown";
}

}  // namespace contourd
