updamp.start();
