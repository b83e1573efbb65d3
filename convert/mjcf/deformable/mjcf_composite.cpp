// composite elements: bodies that MuJoCo generates, and the skins over them.
#include <utility>

#include "convert/mjcf/bodies/mjcf_bodies.h"
#include "convert/mjcf/deformable/composite.h"

namespace fire3dv::convert {

Result<void> MjcfBodyReader::read_composite(const MjcfElement& element, const Scope& scope) {
  MjcfSource& source = *scope.source;
  const MjcfAttributes from = source.attributes(element, scope.class_index);
  // Name as in the file, without the affixes of its copy.
  std::string body = tree_.bodies[scope.body].name;
  if (body.starts_with(scope.prefix) && body.ends_with(scope.suffix) &&
      body.size() >= scope.prefix.size() + scope.suffix.size())
    body = body.substr(scope.prefix.size(), body.size() - scope.prefix.size() - scope.suffix.size());
  const Result<Composite> made = expand_composite(from, body);
  if (!made) {
    from.warn("is left out: " + made.error().message);
    return {};
  }
  if (!made->note.empty()) from.warn(made->note);
  for (const MjcfElement& child : made->children)
    if (Result<void> done = read_child(child, scope); !done) return done;
  if (!made->skin) return {};
  Result<BoundSkin> bound = bind_skin(*made->skin, 0);
  if (!bound) return bound.error();
  MjcfTreeSkin tree_skin;
  MjcfSkin& skin = tree_skin.skin;
  tree_skin.inflation = made->inflation;
  skin.name = scope.name(from.text("prefix") + "Skin");
  skin.rgba = {1, 1, 1, 1};
  for (const MjcfElement& child : element.children) {
    if (child.kind != "skin") continue;
    const MjcfAttributes own = source.attributes(child, MjcfDefaults::kMain);
    skin.group = own.integer("group", 0);
    if (const auto rgba = own.vec4("rgba"))
      for (int i = 0; i < 4; ++i) skin.rgba[static_cast<size_t>(i)] = static_cast<float>((*rgba)[i]);
    if (const std::string material = own.text("material"); !material.empty())
      skin.material = source.material(material, child, assets_);
  }
  for (const SkinData::Bone& bone : made->skin->bones) {
    const auto found = tree_.body_index.find(scope.name(bone.body));
    if (found == tree_.body_index.end()) return {};  // another object has taken the name
    skin.bones.push_back({found->second, {bone.position, bone.rotation}});
  }
  skin.surface = std::move(bound->surface);
  tree_.skins.push_back(std::move(tree_skin));
  return {};
}

}  // namespace fire3dv::convert
