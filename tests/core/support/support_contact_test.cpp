#include "core/support/support_contact.hpp"

#include "tests/catch.hpp"

TEST_CASE("The causes of a contact have names") {
  CHECK(name_of(ContactCause::Island) == "island");
  CHECK(name_of(ContactCause::Overhang) == "overhang");
  CHECK(name_of(ContactCause::Peel) == "peel");
}
