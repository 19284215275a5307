// Checks that each broken rule of a supported print is detected.
#include "tests/reference/supported_print.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

using namespace contourd::reference;

namespace {

// A box 3 mm above the plate on four supports.
SupportedPrint sound_print() {
  SupportedPrint print;
  print.display = {Pixels{240}, Pixels{240}, Micrometers{100.0}};
  print.models.resize(1);
  PlateModel& box = print.models.front();
  box.model = std::make_shared<const HeightIndex>(models::box({-4, -4, 0}, {4, 4, 2}));
  box.elevation = Elevation(Nanometers{3'000'000});
  box.copies.push_back(PixelMap::true_scale(print.display, {0, 0}));
  for (const double x : {-3.0, 3.0}) {
    for (const double y : {-3.0, 3.0}) {
      print.primitives.push_back(Frustum{{x, y, 0}, {x, y, 0.5}, 1.5, 0.5});
      print.primitives.push_back(Frustum{{x, y, 0.5}, {x, y, 1.9}, 0.5, 0.5});
      print.primitives.push_back(Frustum{{x, y, 1.9}, {x, y, 3.2}, 0.5, 0.2});
      print.contacts.push_back({{x, y, 3}, {0, 0, -1}, ContactCause::Overhang, 11});
    }
  }
  return print;
}

std::string broken_by(const SupportedPrint& print) {
  std::string all;
  for (const std::string& sentence : broken_rules(print))
    all += sentence.substr(sentence.find(' ') + 1, sentence.find(',') - sentence.find(' ') - 1) + ";";
  return all;
}

}  // namespace

TEST_CASE("A well-supported print breaks no rule") {
  CHECK(broken_by(sound_print()).empty());
}

TEST_CASE("Each broken rule of a supported print is detected") {
  SupportedPrint print = sound_print();
  print.primitives.clear();
  CHECK(broken_by(print) == "parts of layers begin with nothing below;");
  print = sound_print();
  print.primitives.push_back(Ball{{8, 8, 2}, 0.5});
  CHECK(broken_by(print) == "parts of layers begin with nothing below;");
  print = sound_print();
  print.primitives.push_back(Frustum{{0, 0, 0}, {0, 0, 4}, 0.5, 0.5});
  CHECK(broken_by(print) ==
        "pixels of supports are in a model away from tips;primitives are nearer to a model than the "
        "clearance;");
  print = sound_print();
  print.primitives.push_back(Frustum{{0, 0, 0}, {0, 0, 2.0}, 0.5, 0.4});
  CHECK(broken_by(print).empty());
  print.primitives.push_back(Frustum{{0, 0, 0}, {0, 0, 2.6}, 0.5, 0.4});
  CHECK(broken_by(print) == "primitives are nearer to a model than the clearance;");
  print = sound_print();
  print.primitives.push_back(Frustum{{11.7, 0, 0}, {11.7, 0, 2}, 0.5, 0.5});
  CHECK(broken_by(print) == "primitives are outside the build volume;");
  print = sound_print();
  print.contacts.front().load_mm2 = 11.2;
  CHECK(broken_by(print) == "contacts hold more than they can;");
}
