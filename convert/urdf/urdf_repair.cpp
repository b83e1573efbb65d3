#include "convert/urdf/urdf_repair.h"

#include <cstddef>
#include <string_view>

#include "base/text.h"
#include "base/words.h"

namespace fire3dv::convert {
namespace {

void remove_children(tinyxml2::XMLElement& parent, const char* name) {
  while (tinyxml2::XMLElement* child = parent.FirstChildElement(name)) parent.DeleteChild(child);
}

void repair_scales(tinyxml2::XMLElement& link) {
  for (const char* kind : {"visual", "collision"}) {
    for (tinyxml2::XMLElement* shape = link.FirstChildElement(kind); shape;
         shape = shape->NextSiblingElement(kind)) {
      tinyxml2::XMLElement* geometry = shape->FirstChildElement("geometry");
      tinyxml2::XMLElement* mesh = geometry ? geometry->FirstChildElement("mesh") : nullptr;
      const char* scale = mesh ? mesh->Attribute("scale") : nullptr;
      if (!scale) continue;
      const std::string one(trimmed(scale));
      if (count_words(one) == 1) mesh->SetAttribute("scale", (one + " " + one + " " + one).c_str());
    }
  }
}

// urdfdom drops a visual whose material has no name, and one whose colour has no opacity.
void repair_materials(tinyxml2::XMLElement& parent, size_t& unnamed) {
  tinyxml2::XMLElement* next = nullptr;
  for (tinyxml2::XMLElement* material = parent.FirstChildElement("material"); material; material = next) {
    next = material->NextSiblingElement("material");
    for (tinyxml2::XMLElement* color = material->FirstChildElement("color"); color;
         color = material->FirstChildElement("color")) {
      const char* rgba = color->Attribute("rgba");
      const size_t numbers = count_words(rgba ? rgba : "");
      if (numbers == 3) color->SetAttribute("rgba", (std::string(rgba) + " 1").c_str());
      if (numbers == 3 || numbers == 4) break;
      material->DeleteChild(color);
    }
    if (material->Attribute("name")) continue;
    if (material->FirstChildElement())
      material->SetAttribute("name", ("unnamed material " + std::to_string(++unnamed)).c_str());
    else
      parent.DeleteChild(material);
  }
}

// Returns true if the joint lacks limits.
bool repair_limits(tinyxml2::XMLElement& joint) {
  const char* type = joint.Attribute("type");
  const std::string_view kind = type ? type : "";
  tinyxml2::XMLElement* limit = joint.FirstChildElement("limit");
  const bool is_missing = !limit && (kind == "revolute" || kind == "prismatic");
  if (is_missing) limit = joint.InsertNewChildElement("limit");
  for (const char* value : {"effort", "velocity"})
    if (limit && !limit->Attribute(value)) limit->SetAttribute(value, "0");
  return is_missing;
}

}  // namespace

std::vector<std::string> repair_urdf(tinyxml2::XMLElement& robot, const std::string& name) {
  std::vector<std::string> notes;
  if (!robot.Attribute("name")) {
    robot.SetAttribute("name", name.c_str());
    notes.push_back("the robot has no name; it is called " + quote(name));
  }
  for (const char* unused : {"transmission", "gazebo"}) remove_children(robot, unused);
  size_t unnamed = 0;
  repair_materials(robot, unnamed);
  for (tinyxml2::XMLElement* link = robot.FirstChildElement("link"); link;
       link = link->NextSiblingElement("link")) {
    remove_children(*link, "inertial");
    for (tinyxml2::XMLElement* visual = link->FirstChildElement("visual"); visual;
         visual = visual->NextSiblingElement("visual"))
      repair_materials(*visual, unnamed);
    repair_scales(*link);
  }
  size_t without = 0;
  std::string first;
  for (tinyxml2::XMLElement* joint = robot.FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint")) {
    if (!repair_limits(*joint)) continue;
    if (without++ == 0 && joint->Attribute("name")) first = joint->Attribute("name");
  }
  if (without > 0)
    notes.push_back("joint " + quote(first) +
                    (without > 1 ? " and " + std::to_string(without - 1) + " more" : "") +
                    " should have a <limit>; without one it rests at 0");
  return notes;
}

}  // namespace fire3dv::convert
