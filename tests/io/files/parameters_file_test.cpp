#include <array>
#include <span>
#include <string_view>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::AllOf;
using testing::HasSubstr;

enum class Colour { red, green };
constexpr std::array<std::string_view, 2> kColourNames = {"red", "green"};
constexpr std::span<const std::string_view> choice_names(Colour) { return kColourNames; }

struct Room {
  double width_m = 2.5;
  bool lit = true;
  Colour colour = Colour::red;

  static constexpr auto declarations() {
    return std::tuple{declare(&Room::width_m, "width_m", "m", 0.5, 10.0, "from wall to wall", "section 2"),
                      declare(&Room::lit, "lit", "whether there is light", "section 3"),
                      declare(&Room::colour, "colour", "of the walls", "section 4")};
  }
};

struct House {
  int floors = 8;
  Room room;

  static constexpr auto declarations() {
    return std::tuple{declare(&House::floors, "floors", "", 1, 100, "one above the other", "section 1"),
                      group(&House::room, "room")};
  }
};

class ParametersFileTest : public testing::Test {
 protected:
  void read(const std::string& yaml) {
    write_file_atomically(file, yaml);
    read_parameters_file(file, parameter_references(parameters));
  }
  // The message of the error that reading `yaml` throws.
  template <class ErrorType>
  std::string error_of(const std::string& yaml) {
    try {
      read(yaml);
    } catch (const ErrorType& error) {
      return error.what();
    }
    ADD_FAILURE() << "no such error";
    return "";
  }

  test::TemporaryFolder folder;
  std::filesystem::path file = folder / "config.yaml";
  House parameters;
};

TEST_F(ParametersFileTest, SetsNestedKeysAndKeepsTheRest) {
  read("room:\n  width_m: 0.75\n  lit: false\n");
  EXPECT_EQ(parameters.room.width_m, 0.75);
  EXPECT_FALSE(parameters.room.lit);
  EXPECT_EQ(parameters.room.colour, Colour::red);
  EXPECT_EQ(parameters.floors, 8);
  read("floors: 3\nroom: {colour: green}\n");
  EXPECT_EQ(parameters.floors, 3);
  EXPECT_EQ(parameters.room.colour, Colour::green);
}

TEST_F(ParametersFileTest, AnEmptyFileChangesNothing) {
  read("# nothing\n");
  EXPECT_EQ(parameters.floors, 8);
}

TEST_F(ParametersFileTest, ReadsBackTheWrittenValues) {
  House written{.floors = 77, .room = {.width_m = 10.0 / 3, .lit = false, .colour = Colour::green}};
  House defaults;
  read(parameters_yaml(parameter_references(written), parameter_references(defaults)));
  EXPECT_EQ(parameters.floors, 77);
  EXPECT_EQ(parameters.room.width_m, 10.0 / 3);
  EXPECT_FALSE(parameters.room.lit);
  EXPECT_EQ(parameters.room.colour, Colour::green);
}

TEST_F(ParametersFileTest, WritesMeaningUnitBoundsDefaultAndSource) {
  House defaults;
  parameters.room.width_m = 4;
  EXPECT_EQ(parameters_yaml(parameter_references(parameters), parameter_references(defaults)),
            "# one above the other\n"
            "# [1 to 100; default 8; section 1]\n"
            "floors: 8\n"
            "\nroom:\n"
            "  # from wall to wall\n"
            "  # [0.5 to 10 m; default 2.5; section 2]\n"
            "  width_m: 4\n"
            "  # whether there is light\n"
            "  # [true or false; default true; section 3]\n"
            "  lit: true\n"
            "  # of the walls\n"
            "  # [red or green; default red; section 4]\n"
            "  colour: red\n");
}

TEST_F(ParametersFileTest, NamesFileLineAndKeyOfAnError) {
  EXPECT_THAT(error_of<ParameterError>("floors: 3\nflors: 4\n"),
              AllOf(HasSubstr(file.string() + ":2"), HasSubstr("flors")));
  EXPECT_THAT(error_of<ParameterError>("room:\n  height_m: 1\n"),
              AllOf(HasSubstr(":2"), HasSubstr("room.height_m")));
  EXPECT_THAT(error_of<ParameterError>("room:\n  width_m: -1\n"),
              AllOf(HasSubstr(":2"), HasSubstr("room.width_m"), HasSubstr("-1")));
  EXPECT_THAT(error_of<ParameterError>("\nfloors: four\n"), AllOf(HasSubstr(":2"), HasSubstr("four")));
  EXPECT_THAT(error_of<ParameterError>("floors: 3\nfloors: 4\n"), HasSubstr(":2"));
}

TEST_F(ParametersFileTest, RefusesListsAndMapsInPlaceOfValues) {
  for (const char* yaml : {"floors: [1, 2]\n", "floors:\n", "floors: {a: 1}\n", "room: 3\n", "room:\n",
                           "[1, 2]\n", "3\n", "? [1]\n: 2\n", "room: &a {room: *a}\n"}) {
    SCOPED_TRACE(yaml);
    EXPECT_THROW(read(yaml), ParameterError);
  }
}

TEST_F(ParametersFileTest, RefusesTextThatIsNotYaml) {
  EXPECT_THAT(error_of<InputError>("floors: 3\n  a: [\n"), HasSubstr(file.string() + ":"));
  EXPECT_THROW(read_parameters_file(folder / "absent.yaml", parameter_references(parameters)), InputError);
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
