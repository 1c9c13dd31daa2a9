"""Records of episodes, their files, and failure modes."""
