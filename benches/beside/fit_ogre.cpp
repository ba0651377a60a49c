// OGRE's LiSPSM: LiSPSMShadowCameraSetup for a directional light, with the visible objects' box given.
//
// No render system is needed for it; the scene manager is told what it would have found while walking its scene.
#include <Ogre.h>
#include <OgreDefaultHardwareBufferManager.h>
#include <OgreSceneManagerEnumerator.h>
#include <OgreShadowCameraSetupLiSPSM.h>

#include "protocol.h"

struct Manager : Ogre::DefaultSceneManager {
    using Ogre::DefaultSceneManager::DefaultSceneManager;
    void sees(const Ogre::Camera* camera, const Ogre::AxisAlignedBox& box) {
        Ogre::VisibleObjectsBoundsInfo info;
        info.aabb = info.receiverAabb = box;
        mCamVisibleObjectsMap[camera] = info;
    }
};

int main(int count, char** texts) {
    using namespace Ogre;
    const Given g = given(count, texts);
    (new LogManager())->createLog("", true, false, true);
    Root root("", "", "");
    new DefaultHardwareBufferManager();
    MaterialManager::getSingleton().initialise();
    Manager manager("bench");
    auto placed = [&](MovableObject* object) {
        SceneNode* node = manager.getRootSceneNode()->createChildSceneNode();
        node->attachObject(object);
        return node;
    };
    Camera* eye = manager.createCamera("eye");
    SceneNode* node = placed(eye);
    node->setPosition(Vector3(g.eye[0], g.eye[1], g.eye[2]));
    node->lookAt(Vector3(g.target[0], g.target[1], g.target[2]), Node::TS_WORLD);
    eye->setFOVy(Degree(g.fov_deg));
    eye->setAspectRatio(1);
    eye->setNearClipDistance(g.near);
    eye->setFarClipDistance(g.far);
    Light* light = manager.createLight("light");
    light->setType(Light::LT_DIRECTIONAL);
    light->setShadowFarDistance(g.far);
    placed(light)->setDirection(Vector3(g.light[0], g.light[1], g.light[2]));
    Camera* shadow = manager.createCamera("shadow");
    placed(shadow);
    manager.sees(eye, AxisAlignedBox(g.least[0], g.least[1], g.least[2], g.most[0], g.most[1], g.most[2]));
    const LiSPSMShadowCameraSetup setup;
    auto fit = [&] { setup.getShadowCamera(&manager, eye, nullptr, light, shadow, 0); };
    fit();
    char about[64];
    std::snprintf(about, sizeof about, "OGRE %d.%d.%d", OGRE_VERSION_MAJOR, OGRE_VERSION_MINOR, OGRE_VERSION_PATCH);
    serve(about, g.calls, fit);
    // Its singletons outlive the scene manager; ending here spares their order of destruction.
    std::_Exit(0);
}
